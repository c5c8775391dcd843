"""Hard iron while walking (part of `make accuracy`): every recording with a magnetometer, the table of docs/hard-iron.md.

The recordings are looked for at BEMATIST_SHARED, then beside the project.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pages import DATA, ROOT, fill, required

import bematist as bm

WALKS = {
    "GSU 32, shoe, building": "foot/gsu_gx5/SensorConnectData_32.csv",
    "GSU 35, shoe, run": "foot/gsu_gx5/SensorConnectData_35.csv",
    "openshoe, shoe": "foot/openshoe/OpenShoe_Matlab_Implementation_Measurement_100521_44_data_inert.txt",
    "Nexus 5, texting": "hand/nexus5_mocap/Guillaume_Nexus5_NoDist_Texting",
    "Nexus 5, swinging": "hand/nexus5_mocap/Thibaud_Nexus5_NoDist_Swinging",
    "Nexus 5, calibration": "hand/nexus5_mocap/calib_mag_Nexus5_d1",
    "Indoor Location, site 1": "hand/ms_indoor20/site1_B1_5dda149f9191710006b57212.txt",
    "Indoor Location, site 2": "hand/ms_indoor20/site2_F2_5dd3793144333f00067aa1c7.txt",
    "BROAD 12, undisturbed": "attitude/broad/12_undisturbed_slow_translation_C.mat",
    "BROAD 33, a magnet on the sensor": "attitude/broad/33_disturbed_attached_magnet_2cm.mat",
    "VQF's example": "attitude/vqf/imu_data.npz",
}


def run(recording: bm.Recording, kind: str, use: str) -> tuple[Any, str]:
    """The result of the method of the kind, and its error: of the path in plan where that is known, else of the heading."""
    magnetic = {"hard_iron": {"use": use}}
    truth = recording.reference
    path = kind == "foot" or (truth is not None and truth.attitude is None)
    if not path:
        x = bm.attitude(recording, "hand", attitude={"magnetic": magnetic})
        if truth is None or truth.attitude is None:
            return x, ""
        return x, f"{bm.evaluate_attitude(x, truth, 'yaw').to_dict()['heading_rmse_deg']:.2f}°"
    t = bm.track(
        recording,
        "foot" if kind == "foot" else "hand",
        config={"magnetic": magnetic} if kind == "foot" else {"attitude": {"magnetic": magnetic}},
    )
    if truth is None:
        return t, f"{t.summary()['closure_m']:.3f} m, start to end"
    return t, f"{bm.evaluate(t, truth, 'yaw').ate_plan_m:.3f} m"


def main() -> None:
    required("foot", "hand", "attitude")
    head = ("recording", "found, µT", "±", "ln B at the end, at most", "mean NIS", "jumps", "error off", "`correct`")
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for name, path in WALKS.items():
        recording, kind = bm.read(DATA / path), path.split("/", maxsplit=1)[0]
        _, off = run(recording, kind, "off")
        watched, _ = run(recording, kind, "watch")
        corrected, error = run(recording, kind, "correct")
        d = watched.diagnostics
        found = watched.summary()["hard_iron"]
        told = np.linalg.norm(d["hard_iron"], axis=1) >= 3.0
        most = float(np.max(d["hard_iron_evidence"][told], initial=-99.0))
        applied = bool((corrected.diagnostics["hard_iron_applied"] > 0).any())
        cells = [
            ", ".join(f"{v:.1f}" for v in found["field_ut"]),
            ", ".join(f"{v:.1f}" for v in found["sd_ut"]),
            f"{found['ln_evidence']:.0f}, " + (f"{most:.0f}" if told.any() and most > -99 else "–"),
            f"{found['nis_mean']:.1f}",
            str(found["fields"] - 1),
            off,
            error if applied else "the same",
        ]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
        print(lines[-1], flush=True)
    fill(ROOT / "docs" / "hard-iron.md", "recordings", lines)


if __name__ == "__main__":
    main()
