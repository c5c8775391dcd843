"""MAGINAV's evaluation: Figures 3, 5, 6 and 8, Table 4, and what they leave open."""

from __future__ import annotations

from bematist.reproduce.maginav import attitude, consistency, sensitivity, timing, tuned, walks
from bematist.reproduce.maginav.claims import claims
from bematist.reproduce.maginav.show import show_attitude, show_time, show_tuned, show_walks
from bematist.reproduce.maginav.show_choices import show_consistency, show_sensitivity
from bematist.reproduce.study import Part, Study

STUDY = Study(
    name="maginav",
    title="MAGINAV, reproduced in simulation",
    paper='K. Papafotis, P. P. Sotiriadis, "MAGINAV: Long-Term Accurate Navigation Algorithm Using Inertial and Magnetic Field Sensor '
    'Fusion", IEEE Access 11, 2023, doi:10.1109/ACCESS.2023.3331656',
    introduction=(
        "The paper's own recording is not public. Its walk is simulated instead: the sensor of its Table 3 (LSM9DS1, with the misprints "
        "corrected), a closed walk of 1.3 km in 20 minutes around a campus with parked cars and buildings, and the exact truth, which the "
        "paper did not have. Where a number of the paper is one walk, here is a distribution. What a simulation cannot show is how a real "
        "foot strikes and rolls; see the page on simulation. The equations are the corrected ones, except in `maginav-printed`.",
    ),
    parts=(
        Part("attitude", "Figure 3: five hours at rest", attitude.cases, attitude.compute, show_attitude, 12.0),
        Part("walks", "Figures 5, 6 and 8: the walk", walks.cases, walks.compute, show_walks, 6.0),
        Part("tuned", "The walk again, every method tuned", tuned.cases, walks.compute, show_tuned, 4.5),
        Part("time", "Table 4: run times", timing.cases, timing.compute, show_time, 25.0, alone=True),
        Part("consistency", "Do the filters know how wrong they are?", consistency.cases, consistency.compute, show_consistency, 3.5),
        Part("sensitivity", "Which choices matter", sensitivity.cases, sensitivity.compute, show_sensitivity, 25.0),
    ),
    claims=claims,
)
