"""The command ``mrsfi check``: flies what is kept, and fails where a weakness came back."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi.engines import Given, chosen
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.options import (
    engine_options,
    file_option,
    generated_option,
    seeds_option,
)
from mrsfi_runtime.errors import LimitExceeded, UsageError
from mrsfi_runtime.record.engine_settings import AUTO

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrsfi.regressions import Checked


@click.command(name="check")
@click.argument("mission", metavar="[MISSION|ARCHIVE]", required=False)
@generated_option
@seeds_option(
    "Fly in N mission seeds: those that are kept first, then others, of which limits say "
    "nothing unless they hold there too."
)
@file_option("--junit", "Write the verdicts to FILE as XML for a build server.")
@click.option(
    "--digest",
    metavar="HEX",
    help="Refuse an ARCHIVE unless mrsfi pack printed this digest for it.",
)
@click.option("--github", is_flag=True, help="Also annotate lines of models, for GitHub Actions.")
@engine_options(default=AUTO)
@click.option("--json", "is_json", is_flag=True, help="Print the verdicts for a script.")
def command(
    mission: str | None,
    generated: Path | None,
    engine: Given,
    n_seeds: int | None,
    junit: Path | None,
    digest: str | None,
    github: bool,
    is_json: bool,
) -> None:
    """Fly every kept weakness of MISSION against today's models and code.

    Without MISSION it goes through all of models/. Where a goal has more violations than is kept,
    the weakness came back: it says why, and ends with exit code 10. What cannot be judged any more,
    because a robot or mission.xmi is gone, say, or a window lies beyond the mission, is an error:
    the others are flown all the same, and the exit code is the lowest of such. Nothing kept is no
    pass either.

    The files of an archive of mrsfi pack are compared with its list of their hashes. Then its
    campaign is made once more, by the code in the archive, and compared with what is recorded:
    evaluations, failures, flights, fitness, weaknesses, summary. Whoever changes another file and
    the list changes the digest that mrsfi pack printed; --digest compares it. Options of kept
    weaknesses are refused.

    \b
    Examples:
      mrsfi check
      mrsfi check uuv_sampling --junit regressions.xml
      mrsfi check uuv_sampling --engine reference --seeds 5
      mrsfi check uuv_sampling --json | jq '.uuv_sampling[].state'
      mrsfi check for-the-paper.zip --digest 3f0c…
    """
    from mrsfi.folders import find_mission
    from mrsfi.regressions import check_all, missions_with_kept
    from mrsfi_runtime.cli import verdicts

    if mission is not None and mission.endswith(".zip"):
        is_of_kept = bool(generated or n_seeds or junit or github)
        _repeat(Path(mission), engine, digest, is_of_kept=is_of_kept, is_json=is_json)
        return
    if digest is not None:
        raise click.UsageError("--digest is of an archive of mrsfi pack; expected ARCHIVE")
    if mission is None and generated is not None:
        raise click.UsageError("--generated needs MISSION")
    settings = chosen(engine, AUTO)
    places = [*missions_with_kept()] if mission is None else [find_mission(mission, generated)]
    if not places:
        raise UsageError(
            "found nothing that is kept in models/*/regressions/; expected at least one weakness; "
            "keep one with: mrsfi keep CAMPAIGN --weakness 1"
        )
    found = {each.name: [*check_all(each, settings, tell, n_seeds)] for each in places}
    if junit is not None:
        verdicts.write_junit(junit, found)
        tell(f"written    {junit}")
    every = [each for checked in found.values() for each in checked]
    if is_json:
        told = {name: [*map(verdicts.as_json, checked)] for name, checked in found.items()}
        print_json(told)
    else:
        verdicts.print_tables(found)
    if github:
        verdicts.print_annotations(every)
    _end(every)


def _repeat(
    archive: Path, engine: Given, digest: str | None, *, is_of_kept: bool, is_json: bool
) -> None:
    from mrsfi.campaign import repeat

    if is_of_kept:
        raise click.UsageError(
            f"{archive} is an archive, flown as recorded: --generated, --seeds, --junit and "
            "--github are of kept weaknesses"
        )
    numbers, campaign, found = repeat(archive, engine, digest, tell)
    if is_json:
        print_json({"is_same": True, "digest": campaign, "archive": found, "numbers": numbers})
        return
    told = ", ".join(f"{n} of {n} {kind}" for kind, n in numbers.items())
    click.echo(f"same: {told}")
    click.echo(f"campaign digest {campaign}")
    wanted = "as given" if digest else "compare it with the one that mrsfi pack printed"
    click.echo(f"archive digest {found}: {wanted}")


def _end(every: "Sequence[Checked]") -> None:
    failures = [each.failure for each in every if each.failure is not None]
    unknown = f"; {len(failures)} cannot be judged" if failures else ""
    back = [each.excess for each in every if each.exceeded]
    if back:
        raise LimitExceeded(f"came back: {'; '.join(back)}{unknown}")
    if failures:
        raise min(failures, key=lambda error: error.exit_code)
