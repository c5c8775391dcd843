"""A plan as a picture, placed by its scale and origin or by a world file (six lines: A, D, B, E, C, F)."""

from __future__ import annotations

import io
import math
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageOps, UnidentifiedImageError

from bematist.errors import DataError, UsageError
from bematist.floorplan import FloorPlan, FloorPlanParameters, axes

Array = NDArray[np.float64]
Bounds = tuple[float, float, float, float]

MOST_PIXELS = 80_000_000
"""A larger picture is refused: it takes a quarter of a gigabyte to look at."""

LARGEST_SIDE = 3000
"""A picture with a longer side is drawn smaller: no screen shows more, and the page stays small."""

KEPT_BYTES = 4_000_000
"""A PNG or JPEG that lies straight is embedded as it is up to this size."""


def read(path: Path, given: FloorPlanParameters) -> FloorPlan:
    """The picture with its sides along East and North; one that lies askew, or is large, is drawn anew."""
    picture, media = _open(path)
    A, b = _placed(path, given, picture.height)
    full = np.array(picture.size)
    if full.max() > LARGEST_SIDE:
        media = ""
        picture = picture.convert("RGBA")
        picture.thumbnail((LARGEST_SIDE, LARGEST_SIDE), Image.Resampling.LANCZOS)
        A = A @ np.diag(full / picture.size)
    corners = np.array([[0, 0], [picture.width, 0], [0, picture.height], [picture.width, picture.height]]) @ A.T + b
    (west, south), (east, north) = corners.min(0), corners.max(0)
    bounds = (float(west), float(south), float(east), float(north))
    straight = abs(A[0, 1]) + abs(A[1, 0]) < 1e-9 * abs(A).max() and A[0, 0] > 0 > A[1, 1]
    if media and straight and path.stat().st_size <= KEPT_BYTES:
        return FloorPlan(bounds=bounds, image=path.read_bytes(), media=media, parameters=given)
    return FloorPlan(bounds=bounds, image=_encoded(_drawn(picture, A, b, bounds)), parameters=given)


def _open(path: Path) -> tuple[Image.Image, str]:
    """The picture, upright, and "png" or "jpeg" where a browser shows the file itself in the same way."""
    too_large = f"{path}: the picture has more than {MOST_PIXELS / 1e6:.0f} million pixels. Save it smaller, and give its scale."
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(path)
            if picture.width * picture.height > MOST_PIXELS:
                raise DataError(too_large)
            picture.load()
    except UnidentifiedImageError:
        raise DataError(f"{path}: this is neither a picture (PNG, JPEG, TIFF, GIF, WebP, BMP) nor GeoJSON. Check the file.") from None
    except Image.DecompressionBombError:
        raise DataError(too_large) from None
    except (OSError, ValueError, SyntaxError) as error:
        raise DataError(f"{path}: the picture is damaged ({error}). Save it anew.") from None
    lies = picture.getexif().get(ExifTags.Base.Orientation, 1)
    media = {"PNG": "png", "JPEG": "jpeg"}.get(picture.format or "", "") if lies == 1 else ""
    return ImageOps.exif_transpose(picture), media


def _placed(path: Path, given: FloorPlanParameters, height: int) -> tuple[Array, Array]:
    """A (2,2) and b (2,): East and North, m, of a point of the picture are A (right, down) + b, pixels from its upper left corner."""
    file = _world_file(path) if given.scale is None else None
    turn = axes(given.rotation_deg)
    if file is not None:
        world, corner = _read_world(file)
        return turn @ world, turn @ (corner - np.array(given.origin or (0.0, 0.0)))
    if given.scale is None:
        raise UsageError(f"{path}: how large is the plan? Give --map-scale, the metres of a pixel, or put a world file beside it.")
    if given.origin is None:
        raise UsageError(
            f"{path}: where on the plan is 0, 0 of the path? Give --map-origin X,Y, pixels from the upper left corner to the right and "
            f"down; the lower left corner is 0,{height}."
        )
    A = given.scale * turn @ np.diag([1.0, -1.0])
    return A, -A @ np.array(given.origin)


def _world_file(path: Path) -> Path | None:
    """The world file beside a picture: plan.pgw, plan.pngw or plan.wld of plan.png; None without one."""
    suffix = path.suffix
    names = [path.with_suffix(s) for s in (f"{suffix[:2]}{suffix[-1:]}w", f"{suffix}w", ".wld") if len(s) > 1]
    return next((name for name in names if name.is_file()), None)


def _read_world(file: Path) -> tuple[Array, Array]:
    """A (2,2) and the upper left corner (2,) of a world file, which tells the middle of the upper left pixel."""
    try:
        a, d, b, e, c, f = (float(line) for line in file.read_text("utf-8-sig").split())
    except (OSError, ValueError):
        raise DataError(f"{file}: a world file has six numbers, one a line (A, D, B, E, C, F). Correct it, or give --map-scale.") from None
    A = np.array([[a, b], [d, e]])
    if not np.isfinite([a, b, c, d, e, f]).all() or not abs(np.linalg.det(A)) > 0:
        raise DataError(f"{file}: the numbers of this world file give its pixels no size. Correct it, or give --map-scale.")
    return A, np.array([c, f]) - A @ [0.5, 0.5]


def _drawn(picture: Image.Image, A: Array, b: Array, bounds: Bounds) -> Image.Image:
    """The picture drawn anew with right = East and down = South over its bounds; transparent where it has nothing."""
    west, south, east, north = bounds
    pixel = math.sqrt(abs(float(np.linalg.det(A))))
    pixel = max(pixel, (east - west) / LARGEST_SIDE, (north - south) / LARGEST_SIDE)
    width, height = (max(1, round(side / pixel)) for side in (east - west, north - south))
    # From a pixel of the new picture to one of the old: East and North first, then A backwards.
    back = np.linalg.inv(A)
    step = back @ np.diag([(east - west) / width, -(north - south) / height])
    corner = back @ (np.array([west, north]) - b)
    data = (*step[0], corner[0], *step[1], corner[1])
    return picture.convert("RGBA").transform((width, height), Image.Transform.AFFINE, data, Image.Resampling.BICUBIC)


def _encoded(picture: Image.Image) -> bytes:
    if picture.mode not in ("1", "L", "LA", "P", "RGB", "RGBA"):
        picture = picture.convert("RGBA")
    out = io.BytesIO()
    picture.save(out, "PNG")
    return out.getvalue()
