"""The bundled formats, a file each."""
