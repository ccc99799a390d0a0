#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Images of a chessboard of 9x6 inner corners, 25 mm, as a camera without distortion sees it: draw_boards.py FOLDER SEED IMAGES"""

import sys

import cv2
import numpy as np

focal_px, center = 500.0, np.array([322.0, 236.0])
columns, rows, square_m, cell, finer = 9, 6, 0.025, 40, 4


def random_pose(random):
    """Board to camera: tilted by up to 40 degrees in each direction, all squares in the image."""
    while True:
        rotation, translation = any_pose(random)
        ends = square_m * np.array([[x, y, 0.0] for x in (-1, columns) for y in (-1, rows)])
        points = ends @ rotation.T + translation
        pixels = focal_px * points[:, :2] / points[:, 2:] + center
        if (pixels > 5.0).all() and (pixels < [634.0, 474.0]).all():
            return rotation, translation


def any_pose(random):
    tilt, turn = random.uniform(-0.7, 0.7, 2), random.uniform(-0.5, 0.5)
    rotation = cv2.Rodrigues(np.array([*tilt, 0.0]))[0] @ cv2.Rodrigues(np.array([0.0, 0.0, turn]))[0]
    pixel, distance = random.uniform([60.0, 60.0], [580.0, 420.0]), random.uniform(0.3, 0.6)
    middle = 0.5 * square_m * np.array([columns - 1, rows - 1, 0.0])
    return rotation, distance * np.append((pixel - center) / focal_px, 1.0) - rotation @ middle


def board_image():
    squares = np.indices((rows + 1, columns + 1)).sum(0) % 2
    drawn = np.where(np.kron(squares, np.ones((cell, cell))) > 0, 200, 40).astype(np.uint8)
    return cv2.copyMakeBorder(drawn, cell, cell, cell, cell, cv2.BORDER_CONSTANT, value=200)


def main():
    folder, seed, images = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    random = np.random.default_rng(seed)
    # From pixels of the drawing to meters: a margin and a square lie before the first corner.
    meters = np.array([[1.0, 0.0, 0.5 - 2 * cell], [0.0, 1.0, 0.5 - 2 * cell], [0.0, 0.0, cell / square_m]]) * square_m / cell
    lens = np.array([[focal_px, 0.0, center[0]], [0.0, focal_px, center[1]], [0.0, 0.0, 1.0]])
    enlarge = np.array([[finer, 0.0, (finer - 1) / 2], [0.0, finer, (finer - 1) / 2], [0.0, 0.0, 1.0]])
    drawn = board_image()
    for number in range(images):
        rotation, translation = random_pose(random)
        homography = enlarge @ lens @ np.column_stack((rotation[:, 0], rotation[:, 1], translation)) @ meters
        large = cv2.warpPerspective(drawn, homography, (640 * finer, 480 * finer), flags=cv2.INTER_LINEAR, borderValue=200)
        image = cv2.GaussianBlur(cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA), (0, 0), 0.8)
        cv2.imwrite(f"{folder}/board{number:02d}.png", np.clip(image + random.normal(0.0, 3.0, image.shape), 0, 255).astype(np.uint8))


if __name__ == "__main__":
    main()
