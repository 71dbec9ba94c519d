"""Layout of a campaign folder: every file and subfolder it may hold, named in one place."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from mrsfi_runtime.errors import RecordError


@dataclass(frozen=True, slots=True)
class CampaignFolder:
    """The folder ``runs/<name>`` of one campaign.

    ``model`` and ``generated`` are copies of what the campaign runs on, so that a replay does
    not depend on what was edited since.
    """

    path: Path

    @property
    def model(self) -> Path:
        """Copy of the mission folder: models and campaign settings."""
        return self.path / "model"

    @property
    def generated(self) -> Path:
        """Copy of the generated code with its hand-written regions."""
        return self.path / "generated"

    @property
    def database(self) -> Path:
        """Every evaluation and generation."""
        return self.path / "campaign.sqlite"

    @property
    def critical(self) -> Path:
        """The most critical specifications as XMI."""
        return self.path / "critical"

    @property
    def figures(self) -> Path:
        """Plots as PNG and SVG."""
        return self.path / "figures"

    @property
    def tables(self) -> Path:
        """Numbers behind the figures as CSV."""
        return self.path / "tables"

    @property
    def summary(self) -> Path:
        """What a script reads of the report."""
        return self.path / "summary.json"

    @property
    def report(self) -> Path:
        """What a person reads."""
        return self.path / "report.md"

    @classmethod
    def create(cls, path: Path, models_folder: Path, generated_folder: Path) -> Self:
        """Make the folder and copy the models and the generated code into it.

        Raises
        ------
        RecordError
            If the folder holds something already, or a copy fails.
        """
        folder = cls(path)
        try:
            if path.exists() and (not path.is_dir() or any(path.iterdir())):
                message = (
                    f"{path}: found something there already; expected a new or empty folder. "
                    "Give the campaign another name, or move the old one away"
                )
                raise RecordError(message)
            path.mkdir(parents=True, exist_ok=True)
            _copy_files(models_folder, folder.model)
            _copy_files(generated_folder, folder.generated)
        except OSError as error:
            message = (
                f"{path}: cannot make the campaign folder: {error}; expected a place that can be "
                "written, and readable models and generated code"
            )
            raise RecordError(message) from error
        return folder


def _copy_files(source: Path, target: Path) -> None:
    """Copy the files of one folder, without its subfolders, in order of their names."""
    target.mkdir()
    for file in sorted(source.iterdir()):
        if file.is_file():
            shutil.copyfile(file, target / file.name)
