"""The results of a campaign, read from its folder, and archives that can be repeated.

Scripts use ``Campaign``. ``pack`` writes an archive: the files of a campaign, a list of their
hashes, which ``sha256sum -c`` reads, and the digest of that list in ``REPRODUCE.md``. ``repeat``
compares the files with the list. Then it makes the campaign once more from its own settings, models
and code, and compares the two records. So it detects a changed result, even if all hashes fit it.
"""

import datetime as dt
import lzma
import re
import shutil
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from functools import cached_property
from hashlib import sha256
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrsfi import explaining
from mrsfi.campaign_folders import FlyableCampaign, open_campaign, open_to_fly, require_same
from mrsfi.engines import AS_RECORDED, Given, Tell, again, silent
from mrsfi.evolving import evolve, warn_of_versions
from mrsfi.explaining import evaluations_of, explained, explainer_of_campaign, harvested, report
from mrsfi.flight import Flight, fly, frame
from mrsfi.regressions import keep
from mrsfi_runtime.analysis.fronts import Columns
from mrsfi_runtime.analysis.report import Shown
from mrsfi_runtime.analysis.tables import evaluations_table, to_html
from mrsfi_runtime.analysis.weaknesses import verdict_table
from mrsfi_runtime.causes.explanation import Explanation
from mrsfi_runtime.causes.harvest import KEPT
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.engine.opening import named, open_engine
from mrsfi_runtime.errors import EvaluationError, MrsfiError, RecordError, ReplayMismatch
from mrsfi_runtime.fence import IMPORTED
from mrsfi_runtime.files import whole_file, writable
from mrsfi_runtime.record.database import CampaignFolder, no_writer
from mrsfi_runtime.record.engine_settings import REFERENCE, Workers
from mrsfi_runtime.record.settings import KEEP, CampaignSettings, Regression
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure

if TYPE_CHECKING:
    from pandas import DataFrame

    from mrsfi_runtime.causes.monitors import Study
    from mrsfi_runtime.causes.weakness import Weakness


_LISTED, _INSTRUCTIONS = "SHA256SUMS", "REPRODUCE.md"
_BEFORE, _SHOWN = 30, 150  # characters to print before and after a first difference
_FAILED = "Traceback (most recent call last)"
_MOST_BYTES = 4 * 1024**3
_NO_ZIP = (OSError, zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError)
_UNREADABLE = (*_NO_ZIP, RuntimeError, ValueError, KeyError)
"""Errors of reading an archive; the last three if it is encrypted or of unknown compression, a name
is not text, or the list is missing."""


def pack(run: Path, out: Path, tell: Tell = silent) -> str:
    """Write a campaign's files into an archive; return the digest of the list of their hashes."""
    folder, hashes = CampaignFolder(run), dict[str, str]()
    with (
        CampaignStore.open(run) as store,
        no_writer(folder),
        whole_file(out) as file,
        zipfile.ZipFile(file, "w") as archive,
    ):

        def add(name: str, content: bytes) -> None:
            place = zipfile.ZipInfo(name)  # its date is that of the year 1980, always the same
            archive.writestr(place, content, zipfile.ZIP_DEFLATED)
            hashes[name] = sha256(content).hexdigest()

        for path in folder.files():
            if path.resolve() != out.resolve():
                add(f"campaign/{path.relative_to(run).as_posix()}", path.read_bytes())
        add(_LISTED, "".join(f"{found}  {name}\n" for name, found in hashes.items()).encode())
        add(_INSTRUCTIONS, _instructions(store, hashes[_LISTED]))
    made = [path.stat().st_mtime for path in (folder.summary, folder.database) if path.exists()]
    if made[0] < made[-1] or len(made) == 1:
        tell(
            f"warning: {folder.summary} is missing or older than the record; mrsfi check ends with "
            "exit code 7 where the search has not ended or the summary differs from the record; to "
            f"end the search and write the summary: mrsfi evolve --resume {run}"
        )
    return hashes[_LISTED]


def _instructions(store: CampaignStore, digest: str) -> bytes:
    versions = store.manifest.versions
    listed = "\n".join(f"- {name} {version}" for name, version in versions.items())
    return (
        f"# A campaign of mrsfi\n\nIn `campaign/` are its models, its generated code, its settings "
        f"and every evaluation.\nIt was made with\n\n{listed}\n\nTo repeat all of it:\n\n"
        f"    pip install mrsfi=={versions.get('mrsfi')}\n"
        f"    mrsfi check ARCHIVE --digest {digest}\n\n"
        f"The digest is the SHA-256 of `{_LISTED}`.\n"
    ).encode()


def repeat(
    archive: Path, engine: Given, digest: str | None = None, tell: Tell = silent
) -> tuple[Mapping[str, int], str, str]:
    """Make a campaign once more; return the numbers of equal results, its digest, the archive's.

    ``digest`` is the one that ``pack`` returned. Members that differ from the packed ones are a
    ``RecordError``; results that differ are a ``ReplayMismatch``.
    """
    with _unpacked(archive, digest) as (run, found), CampaignStore.open(run) as store:
        manifest, again = store.manifest, run.with_name("again")
        if manifest.engine.is_foreign:
            raise RecordError(
                f"{archive}: members are as packed (digest {found}); flights are not repeated, "
                "because they need an external simulation or node; expected a campaign without one"
            )
        if not store.n_evaluations:
            raise ReplayMismatch(f"{archive}: holds no evaluation; expected at least one")
        CampaignFolder(run).require_hashes(manifest.sha256)
        tell(f"{archive}: members are as packed; mrsfi now runs the code in it")
        warn_of_versions(manifest, tell)
        shutil.copytree(run, again, ignore=shutil.ignore_patterns(store.path.name))
        CampaignStore.create(again, store.settings, manifest).close()
        with open_to_fly(again, tell) as made:
            _make(made, store, engine, tell)
            numbers = _compared(run, _contents(store), _contents(made.store))
        return numbers, store.digest(), found


def _make(campaign: FlyableCampaign, recorded: CampaignStore, engine: Given, tell: Tell) -> None:
    """Fly the flights after a recorded search, then search, find weaknesses and report."""
    code, settings = campaign.code, recorded.settings
    flown_by = named(again(engine, recorded.manifest.engine), code, settings.mission_seed, tell)
    with open_engine(flown_by, code, settings.mission_seed) as one, suppress(MrsfiError):
        campaign.store.append_flights(
            replace(each, found=one.attempt(each.specification, each.mission_seed))
            for each in recorded.flights()
        )
    explains, watched = recorded.kept(KEPT, str) is not None, nullcontext(lambda _: None)
    too_many_failed = recorded.n_failures >= settings.max_failures
    with suppress(EvaluationError) if too_many_failed else nullcontext():
        evolve(campaign, flown_by, Workers(), watched, explains=explains)
    if campaign.folder.summary.exists():
        ratio = re.search(rb'"ratio": "(.*)"', campaign.folder.summary.read_bytes())
        report(campaign, ratio and ratio[1].decode(errors="replace"), draws=False)


def _contents(store: CampaignStore) -> dict[tuple[str, str], object]:
    """Return the results of a campaign by kind and name, without the name of its folder."""
    run = store.path.parent
    rows = {
        (f"{table}s", f"{table} {row[0]}"): [
            "error" if _FAILED in str(each) else each for each in row
        ]
        for table in ("evaluation", "failure", "generation", "flight")
        for row in store.rows(table)
    }
    names = ("summary.json", "critical/[0-9]*.xmi", "weaknesses/[0-9]*.xmi")
    files = {
        str(path.relative_to(run)): re.sub(rb'\n  "campaign": .*', b"", path.read_bytes())
        for name in names
        for path in run.glob(name)
    }
    found = {"weaknesses": store.kept(KEPT, str), **files}
    return rows | {("parts of the report", name): part for name, part in found.items()}


def _compared(
    run: Path, recorded: Mapping[tuple[str, str], object], again: Mapping[tuple[str, str], object]
) -> Mapping[str, int]:
    """Return the number of results of each kind, if all equal the record."""
    every = {**recorded, **again}
    other = [each for each in every if recorded.get(each) != again.get(each)]
    numbers, others = Counter(kind for kind, _ in every), Counter(kind for kind, _ in other)
    if other:
        then, now = (str(each.get(other[0])) for each in (recorded, again))
        pairs = enumerate(zip(then, now, strict=False))
        begin = next((max(0, place - _BEFORE) for place, (a, b) in pairs if a != b), 0)
        same = ", ".join(f"{n - others[kind]} of {n} {kind}" for kind, n in numbers.items())
        raise ReplayMismatch(
            f"{run}: {other[0][1]} differs from its record: found {now[begin:][:_SHOWN]}, recorded "
            f"{then[begin:][:_SHOWN]}; as recorded are {same}. Expected the same; check "
            "whether the archive, mrsfi, Python or the kind of processor has changed since"
        )
    return numbers


@contextmanager
def _unpacked(archive: Path, digest: str | None) -> Iterator[tuple[Path, str]]:
    """Yield the folder of a packed campaign, and the digest of its list of hashes."""
    listed, instructions = _members(archive)
    found = sha256(listed).hexdigest()
    if digest is not None and digest.lower() != found:
        raise RecordError(
            f"{archive}: found digest {found}; expected {digest}; it is another archive, or its "
            "list of hashes was changed with its members"
        )
    with TemporaryDirectory() as place:
        run = Path(place) / "campaign"
        with writable(Path(gettempdir()), "set TMPDIR to a folder with more room"):
            with zipfile.ZipFile(archive) as content:
                content.extractall(place)
            (run / "generated" / IMPORTED).mkdir(parents=True, exist_ok=True)  # if it was empty
        try:
            with CampaignStore.open(run) as store:
                if instructions != _instructions(store, found):
                    raise _changed(archive, f"{_INSTRUCTIONS} was changed")
            yield run, found
        except MrsfiError as error:
            error.args = (str(error).replace(place, str(archive)),)
            raise


def _members(archive: Path) -> tuple[bytes, bytes]:
    """Return the list of hashes and the text beside it, if all other members match the list."""
    try:
        with zipfile.ZipFile(archive) as content:
            members = content.infolist()
            if sum(each.file_size for each in members) > _MOST_BYTES:
                raise RecordError(f"{archive}: holds more than {_MOST_BYTES} bytes")
            found = {each.filename: sha256(content.read(each)).hexdigest() for each in members}
            listed, instructions = content.read(_LISTED), content.read(_INSTRUCTIONS)
            lines = (line.split("  ", 1) for line in listed.decode().splitlines())
            expected = {name: hashed for hashed, name in lines}
    except _UNREADABLE as error:
        what = f"{archive}: is not an archive of a campaign ({error})"
        raise RecordError(f"{what}; expected one of `mrsfi pack`") from error
    expected |= {name: found[name] for name in (_LISTED, _INSTRUCTIONS)}
    names = {name for name, _ in found.items() ^ expected.items()}
    changes = [
        f"{name} was {'changed' if name in expected else 'added'}"
        if name in found
        else f"{name} is missing"
        for name in sorted(names)
    ]
    if changes or len(found) < len(members):
        raise _changed(archive, ", ".join(changes) or "a member occurs twice")
    return listed, instructions


def _changed(archive: Path, what: str) -> RecordError:
    return RecordError(f"{archive}: {what}; expected the archive as `mrsfi pack` wrote it")


class Campaign:
    """A campaign, running or finished, by its folder: every evaluation and its results.

    Evaluations are numbered from 0 on, in the order in which they were flown.

    Parameters
    ----------
    folder
        The folder that ``mrsfi evolve`` or ``Mission.evolve`` made.

    Raises
    ------
    RecordError
        If it holds no campaign.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        with open_campaign(self.folder) as campaign:
            self._mission = campaign.mission
            self.settings: CampaignSettings = campaign.store.settings

    def __repr__(self) -> str:
        return f"<Campaign {self.folder}, {len(self)} evaluations>"

    def _repr_html_(self) -> str:
        with open_campaign(self.folder) as campaign:
            try:
                known = harvested(campaign)
            except RecordError as error:
                return f"<p>{escape(str(error))}</p>"
            return to_html(verdict_table(campaign.mission, campaign.pool, known))

    def __len__(self) -> int:
        return len(self.fitness)

    @property
    def goals(self) -> tuple[str, ...]:
        """IDs of the goals, the second axis of ``violations``."""
        return self._columns.goals

    @property
    def fitness(self) -> NDArray[np.float64]:
        """Fitness, by which evaluations are ranked, shape ``(n_evaluations,)``."""
        return self._columns.fitness

    @property
    def violations(self) -> NDArray[np.float64]:
        """Violations of the kind that the campaign counts, shape ``(n_evaluations, n_goals)``."""
        return self._columns.violations.astype(np.float64)

    @property
    def weaknesses(self) -> "tuple[Weakness, ...]":
        """All weaknesses, by goal; a ``RecordError`` if the campaign did not search for them."""
        with open_campaign(self.folder) as campaign:
            return harvested(campaign).weaknesses

    @property
    def ways(self) -> tuple[GoalWeakness, ...]:
        """The same by goal and set of faults, numbered as ``keep`` takes them."""
        with open_campaign(self.folder) as campaign:
            return harvested(campaign).goal_weaknesses

    @property
    def digest(self) -> str:
        """SHA-256 over all evaluations: the same for the same search on any machine."""
        with CampaignStore.open(self.folder) as store:
            return store.digest()

    def to_frame(self) -> "DataFrame":
        """Return evaluations as a pandas frame: one row each, with the results of each goal."""
        measure = Measure.of(self.settings, self._mission)
        with CampaignStore.open(self.folder) as store:
            return frame(evaluations_table("", store.flown(1), measure))

    def evaluation(self, index: int) -> Evaluation:
        """Return one evaluation: its specification, fitness and outcome.

        Raises
        ------
        RecordError
            If there is none of that index.
        """
        with CampaignStore.open(self.folder) as store:
            return store.evaluation(index)

    def top(self, n: int = 10) -> tuple[Evaluation, ...]:
        """Return the most critical distinct evaluations, the worst first."""
        with CampaignStore.open(self.folder) as store:
            return tuple(map(store.evaluation, self._columns.top(n)))

    def fly(self, index: int) -> Flight:
        """Fly an evaluation again, on the campaign's own copy of the code; return every tick.

        Raises
        ------
        RecordError
            If the campaign is of other rules of the world, or has no such evaluation.
        ReplayMismatch
            If its outcome differs from the record.
        """
        with open_to_fly(self.folder) as campaign:
            recorded = campaign.store.evaluation(index)
            seed = self.settings.mission_seed
            settings = again(AS_RECORDED, campaign.store.manifest.engine, REFERENCE)
            with open_engine(settings, campaign.code, seed) as engine:
                flight = fly(engine, campaign.pool, recorded.specification, seed)
            require_same(self.folder, recorded, flight.outcome)
            return flight

    def explain(self, index: int | None = None, keep: float = KEEP) -> Explanation | None:
        """Find the causes for which one evaluation breaks goals.

        Parameters
        ----------
        index
            Its index; the most critical one if left out.
        keep
            Share of each goal's violations that a cause set has to keep.

        Returns
        -------
        Explanation or None
            ``None`` if it has no counted violation.

        Raises
        ------
        RecordError
            If the campaign is of other rules of the world, or has no such evaluation.
        ReplayMismatch
            If its outcome differs from the record.
        """
        with open_to_fly(self.folder) as campaign:
            some = [*evaluations_of(campaign, index)]
            about = explainer_of_campaign(campaign)
            settings = again(AS_RECORDED, campaign.store.manifest.engine)
            ((_, found),) = explained(about, some, settings, Workers(), keep)
            return found

    def monitors(self, n_fit: int = 20) -> "Study":
        """Find the monitors that would have detected the weaknesses, fitted in mission seeds."""
        from mrsfi.monitoring import monitored  # noqa: PLC0415 - brings what writes code

        return monitored(self.folder, AS_RECORDED, n_fit)

    def keep(
        self,
        weakness: int = 1,
        name: str | None = None,
        limits: Mapping[str, int] | None = None,
        n_seeds: int = 1,
    ) -> Regression:
        """Keep a weakness beside the models of its mission, as ``mrsfi.regressions.keep`` does."""
        with open_campaign(self.folder) as campaign:
            return keep(campaign, weakness, name, limits, n_seeds)

    def report(self, ratio: str | None = None, *, latex: bool = False) -> Path:
        """Write tables, figures, models and page into the folder; return the report's file.

        Parameters
        ----------
        ratio
            Ratio of violations to pick by, such as ``g3:g1=2:1``.
        latex
            Also write it for a paper, with figures as PDF, and return that file.
        """
        with open_campaign(self.folder) as campaign:
            explaining.report(campaign, ratio, latex=latex, today=dt.date.today())
            return campaign.folder.latex if latex else campaign.folder.report

    def pack(self, out: Path | str) -> str:
        """Pack it into an archive for ``mrsfi check``; return the digest of the archive."""
        return pack(self.folder, Path(out))

    def show(self, weakness: int | None = None) -> tuple[Shown, ...]:
        """Draw a weakness by its number, or the smallest of each goal, as ``mrsfi show`` does."""
        with open_campaign(self.folder) as campaign:
            return tuple(explaining.show(campaign, weakness))

    @cached_property
    def _columns(self) -> Columns:
        measure = Measure.of(self.settings, self._mission)
        with CampaignStore.open(self.folder) as store:
            return Columns.read(store, measure, measure.chosen)
