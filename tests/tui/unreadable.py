"""Input that no keyboard sends: bytes of other encodings, and damaged or faulty escape
sequences.
"""

UNREADABLE = {
    "not UTF-8": b"\xf1",
    "not UTF-8, in the middle": b"\xe2\x82",
    "no such character": b"\x1b[1114112u",
    "a surrogate": b"\x1b[55296u",
    "a surrogate as text": b"\x1b[97;1;55296u",
    "a number too large": b"\x1b[99999999999999999999u",
    "a modifier with a colon": b"\x1b[97;1:2u",
    "a huge window": b"\x1b[48;9999;9999;1;1t",
    "a huge window of many pixels": b"\x1b[48;9999;9999;99999;99999t",
    "a window of nothing": b"\x1b[48;0;0;0;0t",
}
"""By what is wrong with it."""
