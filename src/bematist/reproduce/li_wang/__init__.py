"""Li & Wang's study: its three routes and three laps, with truth; and its claims on simulated and real walks."""

from __future__ import annotations

from bematist.reproduce.li_wang import recordings, routes
from bematist.reproduce.li_wang.claims import claims
from bematist.reproduce.li_wang.show import show_recordings, show_routes
from bematist.reproduce.study import Part, Study

STUDY = Study(
    name="li-wang",
    title="Li & Wang 2019, reproduced",
    paper='X. Li, Y. Wang, "Evaluation of AHRS algorithms for foot-mounted inertial-based indoor navigation systems", Open Geosciences 11, '
    "2019, doi:10.1515/geo-2019-0005",
    introduction=(
        "The paper shows one recording of each course and compares paths by eye. Here each course is simulated many times with the exact "
        "truth, so that every comparison is a count over walks. The equations are the corrected ones, with one set of the settings "
        "that the paper leaves open. A simulated foot is kinder than a real one (see the page on simulation); the same variants are "
        "therefore run on real recordings.",
    ),
    parts=(
        Part("routes", "The courses", routes.cases, routes.compute, show_routes, 5.0),
        Part("recordings", "Real recordings", recordings.cases, recordings.compute, show_recordings, 3.0),
    ),
    claims=claims,
)
