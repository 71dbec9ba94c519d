"""The command ``mrsfi report``."""

from pathlib import Path

import click

from mrsfi_runtime.cli.options import OneOf


@click.command(name="report")
@click.argument("folder", metavar="[CAMPAIGN]", required=False, type=click.Path(path_type=Path))
@click.option("--ratio", metavar="G:H=M:N", help="Pick from the front, such as g3:g1=2:1.")
@click.option(
    "--format",
    "form",
    type=OneOf(("markdown", "latex")),
    default="markdown",
    show_default=True,
    help="With latex, also report.tex and figures as PDF, for a paper.",
)
@click.option("--json", "is_json", is_flag=True, help="Print the summary for a script.")
def command(folder: Path | None, ratio: str | None, form: str, is_json: bool) -> None:
    """Write the report of CAMPAIGN anew and print what breaks which goal.

    Where nobody looked for that, it prints the ten most critical specifications.

    CAMPAIGN is the folder of a campaign, finished or interrupted; without one, the campaign in
    runs/ that was written last. Everything comes from the folder's own copies, whatever was
    edited since.

    \b
    Examples:
      mrsfi report
      mrsfi report runs/uuv_sampling-b-1 --ratio g3:g1=2:1
      mrsfi report runs/uuv_sampling-a-1 --format latex
      mrsfi report runs/uuv_sampling-a-1 --json | jq '.top[].fitness'

    Written into the folder: report.md, summary.json, figures/, tables/, critical/*.xmi and
    weaknesses/*.xmi.
    """
    from mrsfi.campaign_folders import latest_folder, open_campaign
    from mrsfi_runtime.cli.summary import report

    with open_campaign(folder or latest_folder()) as campaign:
        report(campaign, ratio, is_json=is_json, latex=form == "latex")
