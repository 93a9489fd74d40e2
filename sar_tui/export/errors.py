"""The error of an export."""


class ExportError(Exception):
    """Nothing can be exported. The message is one or two clear sentences.

    ``bad_input``: what was asked for cannot be, such as a folder that holds other files.
    """

    def __init__(self, message: str, *, bad_input: bool = False) -> None:
        super().__init__(message)
        self.bad_input = bad_input
