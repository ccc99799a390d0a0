#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""mrcal on the corners that `rastro calibrate` used: compare_with_mrcal.py CALIBRATION_FOLDER IMAGE_FOLDER IMAGE_GLOB SCRATCH

Prints the difference of projections (after the rotation between both frames) and the ratio of the maps of uncertainty, and
fails where they are larger than allowed. For chessboards 9x6 of 25 mm and models with 4 or 5 coefficients.
"""

import json
import subprocess
import sys

import mrcal
import numpy as np
import scipy.optimize
from scipy.spatial.transform import Rotation

largest_difference_px = 0.05  # In the median, and where half the uncertainty is less.
ratios = (0.8, 1.25)


def calibrate(folder, images, pattern, scratch, result, lens):
    """The same model with mrcal, its board flat where rastro found it flat."""
    command = ["mrcal-calibrate-cameras", "--corners-cache", folder + "/corners.vnl", "--lensmodel", lens, "--focal", "530"]
    command += ["--object-spacing", "0.025", "--object-width-n", "9", "--object-height-n", "6", "--outdir", scratch]
    command.append("--skip-outlier-rejection")  # The corners are those that were kept.
    if not result["board"]["bowed"]:
        command.append("--skip-calobject-warp-solve")
    run = subprocess.run(command + [pattern], cwd=images, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        sys.exit("mrcal-calibrate-cameras: " + run.stderr[-500:])
    return mrcal.cameramodel(scratch + "/camera-0.cameramodel")


def main():
    folder, images, pattern, scratch = sys.argv[1:5]
    with open(folder + "/calibration.json", encoding="utf-8") as file:
        result = json.load(file)
    camera = result["cameras"]["camera"]
    ours = np.array([parameter["value"] for parameter in camera["parameters"].values()])
    lens = {8: "LENSMODEL_OPENCV4", 9: "LENSMODEL_OPENCV5"}[len(ours)]
    model = calibrate(folder, images, pattern, scratch, result, lens)
    theirs = model.intrinsics()[1]

    size = camera["trust"]["uncertainty_map"]
    x = (np.arange(size["columns"]) + 0.5) * result["width"] / size["columns"] - 0.5
    y = (np.arange(size["rows"]) + 0.5) * result["height"] / size["rows"] - 0.5
    pixels = np.stack(np.meshgrid(x, y), -1)
    rays = mrcal.unproject(pixels, lens, theirs, normalize=True)
    uncertainty = np.array([np.nan if v is None else v for v in size["px"]]).reshape(size["rows"], size["columns"])
    expected = mrcal.projection_uncertainty(rays, model, atinfinity=True, what="worstdirection-stdev")
    ratio = uncertainty / expected

    def off(rotation):
        return (mrcal.project(rays @ Rotation.from_rotvec(rotation).as_matrix().T, lens, ours) - pixels).ravel()

    difference = np.linalg.norm(scipy.optimize.least_squares(off, np.zeros(3)).fun.reshape(-1, 2), axis=1)
    print(f"{lens}: projection difference {np.median(difference):.4f} px in the median, {difference.max():.4f} px at most; "
          f"uncertainty over mrcal's {np.nanmin(ratio):.3f} to {np.nanmax(ratio):.3f}, median {np.nanmedian(ratio):.3f}")
    if np.median(difference) > largest_difference_px:
        sys.exit("the projections differ")
    if (difference > np.maximum(largest_difference_px, 0.5 * expected.ravel())).any():
        sys.exit("projections differ by more than half their uncertainty")
    if not ratios[0] <= np.nanmedian(ratio) <= ratios[1]:
        sys.exit("the uncertainties differ")


if __name__ == "__main__":
    main()
