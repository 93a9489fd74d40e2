"""Whether a text holds a number, in digits or in words: qualitative feedback must not."""

import re
import unicodedata

_WORDS = {
    "en": """zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen
        seventeen eighteen nineteen twenty thirty forty fifty sixty seventy eighty ninety hundred hundreds thousand
        thousands million millions half halves quarter quarters once twice thrice first second third thirds fourth fifth
        sixth seventh eighth ninth tenth dozen dozens couple pair double triple percent""",
    "es": """cero uno dos tres cuatro cinco seis siete ocho nueve diez once doce trece catorce quince dieciséis
        diecisiete dieciocho diecinueve veinte veintiuno veintiuna veintiún veintidós veintitrés veinticuatro
        veinticinco veintiséis veintisiete veintiocho veintinueve treinta cuarenta cincuenta sesenta setenta ochenta
        noventa cien ciento cientos doscientos trescientos cuatrocientos quinientos seiscientos setecientos ochocientos
        novecientos doscientas trescientas cuatrocientas quinientas seiscientas setecientas ochocientas novecientas mil
        miles millón millones mitad medio media tercio tercios cuarto cuarta cuartos primer primero primera segundo
        segunda tercer tercero tercera quinto quinta sexto sexta séptimo séptima octavo octava noveno novena décimo
        décima docena docenas par doble triple""",
}
"""By language. The Spanish article un, una is not among them: it cannot be told from the number."""


def _folded(text: str) -> str:
    """In small letters, without accents: dieciseis is a number, too."""
    parts = unicodedata.normalize("NFKD", text.lower())
    return "".join(character for character in parts if not unicodedata.combining(character))


NUMBER_WORDS = {language: frozenset(_folded(words).split()) for language, words in _WORDS.items()}
"""The same, folded as `holds_number` compares them."""


def holds_number(text: str, language: str = "en") -> bool:
    """Whether a text holds a number. Of a language whose number words are not known only digits are found."""
    if any(unicodedata.category(character).startswith("N") for character in text):
        return True
    known = NUMBER_WORDS.get(language.partition("-")[0], frozenset())
    return not known.isdisjoint(re.findall(r"[^\W\d_]+", _folded(text)))
