"""`simulate`: a walk that nobody walked, as a recording, with its exact truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import output, progress
from bematist.errors import UsageError
from bematist.outputs import results_folder, to_json

if TYPE_CHECKING:
    from bematist.simulate import HandSimulation, Simulation


@app.command()
def simulate(
    name: Annotated[str | None, typer.Argument(help="The walk, such as campus, laps or still.", metavar="[SCENARIO]")] = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", help="The walk, in another way; campus, or building in the hand.", metavar="NAME")
    ] = None,
    carry: Annotated[
        str | None, typer.Option("--carry", help="Not on the shoe: texting, phoning, swinging, pocket, bag or table.", metavar="NAME")
    ] = None,
    sensor: Annotated[
        str | None, typer.Option("--sensor", help="Its errors and rates; lsm9ds1, or phone in the hand.", metavar="NAME")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Of the random numbers.", min=0)] = 0,
    length: Annotated[float | None, typer.Option("--length", help="Length of the path, m.", metavar="M")] = None,
    duration: Annotated[float | None, typer.Option("--duration", help="Duration of a rest (still), s.", metavar="S")] = None,
    gait: Annotated[str | None, typer.Option("--gait", help="One gait for the whole way, such as run.", metavar="NAME")] = None,
    rate: Annotated[float | None, typer.Option("--rate", help="Rate of accelerometer and gyroscope, Hz.", metavar="HZ")] = None,
    undisturbed: Annotated[bool, typer.Option("--undisturbed", help="Leave the Earth's magnetic field alone.")] = False,
    folder: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of the files; without it, named after the walk.", metavar="DIR")
    ] = None,
    sets: options.Set = None,
    quiet: options.Quiet = False,
) -> None:
    """Simulate a walk, on the shoe or in the hand, and its truth.

    Writes recording.csv, truth.csv and simulation.json; with --carry steps.csv and modes.csv too. Walks: campus, building, short, straight,
    still, stairs, rectangle, ellipse, mixed, laps, and tumble, a sensor turned about in the hand. Sensors: lsm9ds1, adis16488, phone,
    ideal. Gaits: slow, walk, brisk, jog, run, stairs.
    """
    from bematist.simulate import SCENARIOS, simulate_hand, simulate_walk

    walk = name or scenario or ("building" if carry else "campus")
    given = {"length_m": length, "rest_s": duration, "gait": gait, "rate_hz": rate, "disturbed": False if undisturbed else None}
    changes = {k: v for k, v in given.items() if v is not None} | config.assignments(sets or [])
    if duration is not None and walk in SCENARIOS and len(SCENARIOS[walk].waypoints) > 1:
        raise UsageError(f'--duration is for a rest such as "still"; a walk ends when "{walk}" is walked. Use --length, or --gait.')
    folder = Path(walk) if folder is None else folder
    with results_folder(folder) as place:
        with progress("simulating", quiet=quiet):
            if carry:
                made = simulate_hand(walk, carry, sensor or "phone", seed, **changes)
            else:
                made = simulate_walk(walk, sensor or "lsm9ds1", seed, **changes)
        with progress("writing", quiet=quiet):
            _write(made, place)
    if not quiet:
        text = f"{len(made.recording):,} samples in {folder / 'recording.csv'}, the truth in {folder / 'truth.csv'}"
        output().print(text, soft_wrap=True)


def _write(made: Simulation[Any], place: Path) -> None:
    from bematist.io import write_recording, write_reference
    from bematist.simulate import HandSimulation

    write_recording(made.recording, place / "recording.csv")
    assert made.recording.reference is not None
    write_reference(made.recording.reference, place / "truth.csv")
    facts = _facts(made)
    if isinstance(made, HandSimulation):
        _write_steps(made, place)
        facts = {"steps": facts.pop("strides"), **facts, "walker": made.walker.model_dump(), "pointing": made.pointing}
    (place / "simulation.json").write_text(to_json(facts), "utf-8")


def _write_steps(made: HandSimulation, place: Path) -> None:
    import polars as pl

    steps = made.steps
    columns = ("begin", "time", "length_m", "frequency_hz", "motion", "carry")
    table = pl.DataFrame({column: getattr(steps, column) for column in columns})
    table.with_columns(pl.col(pl.Float64).round(6)).write_csv(place / "steps.csv")
    pl.DataFrame(made.spans(), schema=["begin", "end", "motion", "carry"], orient="row").write_csv(place / "modes.csv")


def _facts(made: Simulation[Any]) -> dict[str, Any]:
    e = made.errors
    return {
        "duration_s": made.motion.duration_s,
        "distance_m": float(made.motion.along[-1]),
        "strides": len(made.motion.along) - 1,
        "seed": made.seed,
        "errors": {
            "note": "measured = matrix · true + bias + noise, SI and µT; the biases of accelerometer and gyroscope are those at the start",
            "accel_bias": e.accel_bias[0],
            "gyro_bias": e.gyro_bias[0],
            "magnetic_bias": e.magnetic_bias,
            "accel_matrix": e.accel_matrix,
            "gyro_matrix": e.gyro_matrix,
            "magnetic_matrix": e.magnetic_matrix,
            "gyro_g_sensitivity": e.gyro_g_sensitivity,
        },
        "scenario": made.scenario.model_dump(),
        "sensor": made.sensor.model_dump(),
    }
