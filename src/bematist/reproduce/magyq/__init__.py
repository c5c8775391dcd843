"""MAGYQ's evaluation: Figures 5 to 7 and 9 to 13, the test of section 3.3.2, and what they leave open."""

from __future__ import annotations

from bematist.reproduce.magyq import consistency, gyroscope, outdoors, rest, walks
from bematist.reproduce.magyq.claims import RULE, claims
from bematist.reproduce.magyq.show import show_consistency, show_gyroscope, show_outdoors, show_rest, show_test
from bematist.reproduce.magyq.show_walks import show_held, show_walks
from bematist.reproduce.study import Part, Study

STUDY = Study(
    name="magyq",
    title="MAGYQ, reproduced in simulation",
    paper='V. Renaudin, C. Combettes, "Magnetic, Acceleration Fields and Gyroscope Quaternion (MAGYQ)-Based Attitude Estimation with '
    'Smartphone Sensors for Indoor Pedestrian Navigation", Sensors 14, 2014, doi:10.3390/s141222864',
    introduction=(
        "The paper's recordings are not public. Its tests are simulated instead, with exact truth, which the paper had outdoors only: "
        "the sensor of its Tables 1 and 2 (ADIS16488, with the units corrected), and a phone, whose sensors the title speaks of. Where "
        "the paper has one walk, here is a distribution. The simulated building has what the paper assumes, a field that is constant by "
        "regions; a real one is less kind. The equations are the corrected ones, and `magyq-estimated` and `hand` are not the paper's.",
        RULE,
    ),
    parts=(
        Part("quaternion", "Figures 5 to 7: the gyroscope quaternion", gyroscope.cases, gyroscope.compute, show_gyroscope, 6.0),
        Part("test", "Section 3.3.2: the test of Kolmogorov and Smirnov", gyroscope.test_cases, gyroscope.compute_test, show_test, 0.3),
        Part("rest", "Figure 9: 5000 s at rest", rest.cases, rest.compute, show_rest, 8.0),
        Part("outdoors", "Figure 10: a walk with the offset known too large", outdoors.cases, outdoors.compute, show_outdoors, 3.5),
        Part("walks", "Figures 11 to 13: three walkers, indoors and out", walks.cases, walks.compute, show_walks, 4.5),
        Part("held", "The walk with the rest at the start in the hand", walks.held_cases, walks.compute, show_held, 3.0),
        Part("consistency", "Does the filter know how wrong it is?", consistency.cases, consistency.compute, show_consistency, 0.8),
    ),
    claims=claims,
)
