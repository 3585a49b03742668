"""One PNG a picture, each written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import cv2

from perception.errors import PerceptionInputError
from perception.view.lettering import Picture


class PictureFolder:
    """Makes the folder; PerceptionInputError if it cannot be made or written to."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PerceptionInputError(f"--out = '{folder}': cannot be made a folder: {error.strerror}") from None
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PerceptionInputError(f"--out = '{folder}': cannot be written to; a folder that you may write to is wanted")

    def add(self, stem: str, picture: Picture) -> Path:
        """The file that `picture` was written to; an older one of that name is replaced."""
        target = self._folder / f"{stem}-discs.png"
        new = target.with_name(f".{target.name}")
        try:
            new.write_bytes(cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes())
            new.replace(target)
        except OSError as error:
            new.unlink(missing_ok=True)
            raise PerceptionInputError(f"{target}: cannot be written: {error.strerror}") from None
        return target
