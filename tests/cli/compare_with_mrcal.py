#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""mrcal on the corners that `rastro calibrate` used: compare_with_mrcal.py CALIBRATION_FOLDER

Prints the difference of projections (after the rotation between both frames) and the ratio of the maps of uncertainty, and
fails where they are larger than allowed. For chessboards 9x6 of 25 mm and models with 4 or 5 coefficients.

So that both solve the same problem, mrcal begins at rastro's lens with the poses of cv2.SOLVEPNP_IPPE (its own start puts
steep boards on the wrong side, where it stays and takes their corners for outliers), rejects no corners, and has the board
flat where rastro has. Its priors (do_apply_regularization) pull coefficients that the corners hardly determine to 0: without them
the two agree all over the image, with them where boards were.
"""

import json
import sys

import cv2
import mrcal
import numpy as np
import scipy.optimize
from scipy.spatial.transform import Rotation

largest_difference_px = 0.05
ratios = (0.8, 1.25)
near_px = 20.0  # A place of the image so near to a corner is one where boards were.
columns, rows, square_m = 9, 6, 0.025


def read_corners(folder):
    """Per frame 54 rows of x, y, weight; the weight is -1 where a corner was left out."""
    frames = {}
    with open(folder + "/corners.vnl", encoding="utf-8") as file:
        for name, x, y, _ in (line.split() for line in file if not line.startswith("#")):
            frames.setdefault(name, []).append((-1.0, -1.0, -1.0) if x == "-" else (float(x), float(y), 1.0))
    return np.array(list(frames.values()))


def start_pose(corners, lens, parameters):
    """Of one frame, as rotation and translation."""
    grid = np.array([[x * square_m, y * square_m, 0.0] for y in range(rows) for x in range(columns)])
    seen = corners[:, 2] > 0.0
    rays = mrcal.unproject(corners[seen, :2].copy(), lens, parameters)
    _, turns, moves, _ = cv2.solvePnPGeneric(grid[seen], rays[:, :2] / rays[:, 2:], np.eye(3), None, flags=cv2.SOLVEPNP_IPPE)
    return np.concatenate((turns[0].ravel(), moves[0].ravel()))


def calibrate(result, corners, lens, parameters, priors):
    """The same model with mrcal."""
    inputs = {
        "intrinsics": parameters[np.newaxis].copy(),
        "extrinsics_rt_fromref": np.zeros((0, 6)),
        "frames_rt_toref": np.array([start_pose(frame, lens, parameters) for frame in corners]),
        "points": None,
        "observations_board": corners.reshape(-1, rows, columns, 3).copy(),
        "indices_frame_camintrinsics_camextrinsics": np.array([(k, 0, -1) for k in range(len(corners))], dtype=np.int32),
        "observations_point": None,
        "indices_point_camintrinsics_camextrinsics": None,
        "lensmodel": lens,
        "imagersizes": np.array([[result["width"], result["height"]]], dtype=np.int32),
        "calobject_warp": np.zeros(2),
        "do_optimize_calobject_warp": result["board"]["bowed"],
        "do_optimize_intrinsics_core": True,
        "do_optimize_intrinsics_distortions": True,
        "do_optimize_frames": True,
        "do_optimize_extrinsics": True,  # There are none, but its uncertainty asks for it.
        "do_apply_regularization": priors,
        "do_apply_outlier_rejection": False,
        "calibration_object_spacing": square_m,
    }
    mrcal.optimize(**inputs)
    return mrcal.cameramodel(optimization_inputs=inputs, icam_intrinsics=0)


def compare(result, corners, priors):
    """Whether both agree. Differences are of rastro's lens, ratios of its map over mrcal's."""
    camera = result["cameras"]["camera"]
    ours = np.array([parameter["value"] for parameter in camera["parameters"].values()])
    lens = {8: "LENSMODEL_OPENCV4", 9: "LENSMODEL_OPENCV5"}[len(ours)]
    model = calibrate(result, corners, lens, ours, priors)
    size = camera["trust"]["uncertainty_map"]
    x = (np.arange(size["columns"]) + 0.5) * result["width"] / size["columns"] - 0.5
    y = (np.arange(size["rows"]) + 0.5) * result["height"] / size["rows"] - 0.5
    pixels = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
    rays = mrcal.unproject(pixels, lens, model.intrinsics()[1], normalize=True)
    uncertainty = np.array([np.nan if value is None else value for value in size["px"]])
    ratio = uncertainty / mrcal.projection_uncertainty(rays, model, atinfinity=True, what="worstdirection-stdev")

    def off(rotation):
        return (mrcal.project(rays @ Rotation.from_rotvec(rotation).as_matrix().T, lens, ours) - pixels).ravel()

    difference = np.linalg.norm(scipy.optimize.least_squares(off, np.zeros(3)).fun.reshape(-1, 2), axis=1)
    seen = corners[corners[..., 2] > 0.0][:, :2]
    covered = np.array([np.linalg.norm(seen - pixel, axis=1).min() < near_px for pixel in pixels])
    print(
        f"{lens}, {'with' if priors else 'without'} mrcal's priors: projections differ by at most {difference[covered].max():.4f} px "
        f"where boards were and {difference.max():.4f} px anywhere; uncertainty over mrcal's {np.nanmin(ratio):.3f} to {np.nanmax(ratio):.3f}"
    )
    where = covered if priors else np.ones_like(covered)
    return difference[where].max() <= largest_difference_px and ratios[0] <= np.nanmin(ratio) and np.nanmax(ratio) <= ratios[1]


def main():
    with open(sys.argv[1] + "/calibration.json", encoding="utf-8") as file:
        result = json.load(file)
    corners = read_corners(sys.argv[1])
    agree = [compare(result, corners, priors) for priors in (False, True)]
    if not all(agree):
        sys.exit("the calibrations differ")


if __name__ == "__main__":
    main()
