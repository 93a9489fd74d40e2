"""Bad input: each line is refused with exit code 2 and a sentence, and nothing is stored."""

import shlex

import pytest

from tests.program import Call

REFUSED = """
nonsense -> Usage: sar-tui
--nonsense -> Usage: sar-tui
simulate -> Usage: sar-tui
tasks nonsense -> Usage: sar-tui
run keyboard -> Usage: sar-tui
show -> Usage: sar-tui
graph -> Usage: sar-tui

sessions -p '' -> A participant code has 1 to 32 letters
sessions -p 'Jane Doe' -> A participant code has 1 to 32 letters
sessions -p P99 -> There is no participant P99.
progress '' -> A participant code has 1 to 32 letters
show '' -> There is no session with an empty name.
show zzz -> There is no session zzz. `sar-tui sessions` lists them.
wizard '' -> The session's id is missing: it is empty.
tasks check '' -> a name is missing: it is empty.
themes check '' -> a name is missing: it is empty.
themes check noon -> There is no theme or folder noon. Choose one of: calm, high-contrast, playful.
themes new calm -> There is a theme calm already. Choose another name.
themes new evening --from noon -> There is no theme noon. Choose one of: calm, high-contrast, playful.
tasks show juggling -> There is no task juggling
tasks new mine --from chess -> chess
tasks check /no/such -> /no/such
link check '' -> a name is missing: it is empty.
--tasks /no/such tasks -> There is no folder /no/such for tasks.
tasks --tasks /no/such -> There is no folder /no/such for tasks.
graph juggling -> There is no task juggling. Choose one of: flanker,

simulate '' --user average -> There is no task with an empty name.
simulate juggling --user poor -> There is no task juggling. Choose one of: flanker,
simulate keyboard --user nobody -> --user
simulate keyboard --user poor --theme '' -> There is no theme with an empty name.
simulate keyboard --user poor --theme nope -> There is no theme nope. Choose one of: calm,
simulate keyboard --user poor --theme [red]:warning:[/x] -> There is no theme [red]:warning:[/x].
simulate keyboard --user poor --set attempts -> NAME=VALUE
simulate keyboard --user poor --set =3 -> NAME=VALUE
simulate keyboard --user poor --set x=1 -> `sar-tui tasks show keyboard` lists what can be set.
simulate keyboard --user poor --set atempts=3 -> Did you mean attempts?
simulate keyboard --user poor --set attempts=many -> Attempts is a whole number, 1 to 200, not many.
simulate keyboard --user poor --attempts 0 -> Attempts is a whole number, 1 to 200, not 0.
simulate keyboard --user poor --set start_level=4 --set max_level=2 -> must be between 1 and 2.
simulate keyboard --user poor -p 'Jane Doe' -> Never use a name.
simulate keyboard --user poor --seed -1 -> --seed
simulate keyboard --user poor --fatigue 9 -> --fatigue
simulate keyboard --user poor --operator nobody -> is not one of 'careful', 'hasty', 'absent'
simulate keyboard --user poor --user poor -> is for 1: give --user no more often.
simulate keyboard --user poor -p a -p b -> is for one: name one participant only.
simulate pairs --user poor -p a -p A -> A cannot sit at both seats: name two participants.
simulate pairs --user poor -p a -p b -p c -> At most two participants can take part.

run juggling -p P01 -> There is no task juggling.
run keyboard -p P01 --theme nope -> There is no theme nope.
run keyboard -p P01 --set attempts=0 -> Attempts is a whole number
run keyboard -p - -> A participant code has
run keyboard -p P01 --imu simulated -> uses no motion sensor: leave out --imu.
run reaching -p P01 --imu simulatd -> There is no sensor "simulatd".
run reaching -p P01 --imu simulated:nobody -> There is no simulated hand "nobody".
run reaching -p P01 --imu recorded:none.csv -> There is no file none.csv.
run reaching -p P01 --imu session:zzz -> There is no session zzz.
run reaching -p P01 --imu '' -> Motion sensor
run pairs -p P01 -p P02 --imu-trunk simulated -> The task pairs uses no sensor on the trunk
run keyboard -p P01 --imu-trunk simulated -> The task keyboard uses no sensor on the trunk
run reaching -p P01 --imu-trunk nothing -> There is no sensor "nothing"
run reaching -p P01 --imu phidget:7 --imu-trunk phidget:7 -> Both sensors are named phidget:7
run pairs -p P01 -p P02 --imu simulated -> uses no motion sensor with these settings
run pairs -p P01 -p P02 --set respond_with=reaches -> Both sensors are named phidget.
run pairs -p P01 -p P02 --set respond_with=reaches --imu simulated:unheard -> There is no simulated hand
run pairs -p p01 -> for two: name the participant on the left, and then the one on the right.
run keyboard -p P01 --plain --sync-flash -> Plain lines have no screen that flashes: leave out --sync-flash.
run keyboard -p P01 --outputs screen,sceen -> There is no output "sceen". Did you mean screen?
run keyboard -p P01 --speech nowhere -> nowhere
simulate keyboard --user poor --outputs screen,sceen -> There is no output "sceen".
simulate keyboard --user poor --outputs tones:bang -> There is no tone "bang".
simulate keyboard --user poor --outputs screen,tones,tones:go -> tones is named twice.
simulate keyboard --user poor --outputs servo:not-a-number -> servo
simulate keyboard --user poor --speech nowhere -> nowhere
simulate keyboard --user poor --speech file: -> file:
simulate keyboard --user poor --language English -> Language takes a code in lower case
robots --say Hello -> Name the robot: sar-tui robots ADDRESS.
robots speech -> speech is not a robot. Use one of: ros4hri://HOST
robots '' -> An empty address is not a robot.
robots furhat:// -> Use furhat://HOST or furhat://HOST:PORT
robots furhat://robot --gesture somersault -> There is no gesture somersault. Choose one of: nod,
robots servo --quiet -> leave out --quiet.
robots reachy://robot --quiet --say Hello -> --quiet goes without --say and --gesture.
run keyboard -p P01 --outputs screen,furhat://robot?keyfile=x -> keyfile
run keyboard -p P01 --markers mqtt://broker -> use lsl, udp://HOST:PORT or serial:PORT
--markers lsl sessions -> --markers goes after the command
--sync-flash sessions -> --sync-flash goes after the command
resume -> There is no interrupted session to resume.
resume zzz -> There is no session zzz.
resume last -> There is no interrupted session to resume.

export --to out -> Say which sessions
export --all -p P01 --to out -> Say which sessions
export --all --mixed --simulated --to out -> give one of them
export zzz --to out -> There is no session zzz
export -p P99 --to out -> There is no participant P99.
export --all --format xls --to out -> There is no format xls. Choose one of: csv
report wizard nope -> `sar-tui sessions` lists them.
report wizard '' -> `sar-tui sessions` lists them.
reanalyse zzz -> There is no session zzz.
record add fim P01 -> There is no kind of record fim.
record show ffffff -> ffffff
record correct ffffff outcome=well -> ffffff
progress P1 -> There is no participant P1. Is it P01?
progress P99 --json -> There is no participant P99.
progress 'not a code' -> A participant code has 1 to 32 letters
progress P01 --task reaching -> P01 has no finished attempts of the task reaching yet.
progress P01 --language fr -> Choose one of: en, de, es.
progress P01 --compare last -> --compare takes two sessions
progress P01 --compare last,zz -> No session with a finished attempt of P01 begins with zz.
replay last --fork -> --fork needs --what-if
replay last --runs 20 -> --runs is for --fork only.
replay last --speed 2 -> --speed is for --watch only.
replay last --watch --json -> give neither --what-if nor --json with it.
replay last --what-if 900 -> --what-if takes NAME=VALUE
validate --only figure-9.9 -> There is no validation figure-9.9. Choose one of: figure-4.4,
validate --only table-4.1,x -> no validation x.
validate --only , -> Name a validation
validate --session last --full -> leave out

detect none.csv -> There is no file none.csv.
detect none.csv --detector best -> 'best' is not one of 'orientation', 'single-axis'
detect none.csv --one-way --repetitions -> --one-way goes neither with --repetitions nor with
detect none.csv --one-way --detector=single-axis -> --one-way goes neither with --repetitions
serve observer --port 0 --host 192.0.2.1 -> This machine has no address 192.0.2.1
serve observer --port 0 --host '' -> There is no host
serve observer --port 0 --public-url lab.example -> is not a valid public URL
serve observer --port 0 --link /no/such.file -> There is no file /no/such.file
serve observer --port 0 --link pyproject.toml --session abc -> leave out --session
serve observer --port 0 --token-file pyproject.toml -> token file
serve observer --port 0 --name anna -> Only an operator has a name
serve operator --port 0 --name 'Anna B.' -> is not a valid name
programme import P01 keyboard --preset mild -> Say why the programme changes
programme import P01 keyboard --reason why -> either a file or a preset
programme import P01 keyboard --preset light --reason why -> has no preset light.
merge --site BERN -> are about another database: name it
merge --one-site -> are about another database: name it
timing --trials 1 -> --trials
passphrase --remove --tries -> Give either --remove or --tries.
--patient P01 sessions -> --patient goes without a command
"""
LINES = [line.split(" -> ") for line in REFUSED.strip().splitlines() if line]


def test_bad_input_is_refused_in_a_sentence(
    call: Call, simulated: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.link.discovery.live_sessions", list)
    for command, said in LINES:
        called = call("", *shlex.split(command))
        assert (called.code, called.out) == (2, ""), command
        assert said in " ".join(called.err.split()), (command, called.err)
        assert "╭" not in called.err, "no frames"
    assert [row["id"] for row in call("sessions --json").json["sessions"]] == [simulated]
