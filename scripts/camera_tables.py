#!/usr/bin/env python3
"""Reference tables of cameras, by OpenCV: crates/boxplus/tests/reference/{cameras,locate}.csv

    pip install numpy opencv-python-headless && python3 scripts/camera_tables.py

A row is a model, its intrinsics, a point in the frame of the camera, its pixel, and the derivatives of the pixel by the point, by rows.
They come from cv2.projectPoints and cv2.fisheye.projectPoints with an identity pose; the derivative by its translation is that by
the point. locate.csv: a pose camera_from_world (rotation vector, translation) that cv2.solvePnP found, with points and noisy pixels; and a
point that cv2.triangulatePoints found from the pixels of two cameras. Bundler's camera is OpenCV's pinhole without tangential part, turned half around x and with v upwards.
"""
import random
from pathlib import Path

import cv2
import numpy as np

OUT = Path(__file__).resolve().parent.parent / "crates/boxplus/tests/reference"
rng = random.Random(20261124)
HALF_TURN = np.diag([1.0, -1.0, -1.0])


def matrix(fx, fy, cx, cy):
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def pinhole(intrinsics, point):
    fx, fy, cx, cy, *distortion = intrinsics
    zero = np.zeros(3)
    pixel, jacobian = cv2.projectPoints(
        point.reshape(1, 1, 3), zero, zero, matrix(fx, fy, cx, cy), np.array(distortion)
    )
    return pixel.ravel(), jacobian[:, 3:6]


def fisheye(intrinsics, point):
    fx, fy, cx, cy, *distortion = intrinsics
    zero = np.zeros((3, 1))
    pixel, jacobian = cv2.fisheye.projectPoints(
        point.reshape(1, 1, 3), zero, zero, matrix(fx, fy, cx, cy), np.array(distortion)
    )
    return pixel.ravel(), jacobian[:, 11:14]


def snavely(intrinsics, point):
    f, k1, k2 = intrinsics
    pixel, jacobian = pinhole([f, f, 0, 0, k1, k2, 0, 0, 0], HALF_TURN @ point)
    flip = np.diag([1.0, -1.0])
    return flip @ pixel, flip @ jacobian @ HALF_TURN


CAMERAS = [
    ("pinhole", pinhole, [458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 1.9359e-4, 1.76187e-5, 0.0]),
    ("pinhole", pinhole, [1200.5, 1190.25, 640.0, 360.5, 0.11, -0.24, 1.5e-3, -2.25e-3, 0.09]),
    ("pinhole", pinhole, [500.0, 500.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ("fisheye", fisheye, [190.978, 190.973, 254.932, 256.897, 3.4823e-3, 7.1503e-4, -2.0532e-3, 2.0293e-4]),
    ("fisheye", fisheye, [380.0, 381.5, 630.0, 402.0, -0.011, 0.018, -0.0125, 0.002]),
    ("snavely", snavely, [399.75152639358436, -3.177064385280358e-07, 5.8820490534594022e-13]),
    ("snavely", snavely, [1500.0, -0.05, 0.012]),
]


def main():
    lines = ["model,intrinsics,point,pixel,d_pixel_d_point"]
    for name, project, intrinsics in CAMERAS:
        for spread in [0.0, 1e-6, 0.05, 0.3, 0.6]:
            for _ in range(4):
                depth = rng.uniform(0.5, 20.0)
                aside = [depth * spread * rng.uniform(-1, 1) for _ in range(2)]
                point = np.array([*aside, -depth if name == "snavely" else depth])
                pixel, jacobian = project(intrinsics, point)
                cells = [intrinsics, point, pixel, jacobian.ravel()]
                lines.append(",".join([name] + [" ".join(repr(float(x)) for x in cell) for cell in cells]))
    (OUT / "cameras.csv").write_text("\n".join(lines) + "\n")
    rows = [["pnp", *pose_of_points()], ["triangulation", *point_of_pixels()]]
    text = [",".join([name] + [repr(float(x)) for x in numbers]) for name, *numbers in rows]
    (OUT / "locate.csv").write_text("\n".join(text) + "\n")


K = matrix(500.0, 510.0, 320.0, 240.0)


def pose_of_points():
    rotation, translation = np.array([0.2, -0.3, 0.1]), np.array([0.4, -0.1, 0.5])
    points = np.array([[rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(4, 8)] for _ in range(12)])
    pixels, _ = cv2.projectPoints(points, rotation, translation, K, None)
    pixels = pixels.reshape(-1, 2) + np.array([[rng.gauss(0, 0.7), rng.gauss(0, 0.7)] for _ in range(12)])
    _, r, t = cv2.solvePnP(points, pixels, K, None, flags=cv2.SOLVEPNP_ITERATIVE)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 1000, 1e-15)
    r, t = cv2.solvePnPRefineLM(points, pixels, K, None, r, t, stop)
    return [*r.ravel(), *t.ravel(), *np.hstack([points, pixels]).ravel()]


def point_of_pixels():
    baseline, point = 0.7, np.array([0.5, 0.3, 5.0])
    projections = [K @ np.hstack([np.eye(3), [[-x], [0], [0]]]) for x in (0.0, baseline)]
    pixels = [(p @ np.append(point, 1))[:2] / (p @ np.append(point, 1))[2] for p in projections]
    found = cv2.triangulatePoints(*projections, *[p.reshape(2, 1) for p in pixels]).ravel()
    return [*(found[:3] / found[3]), baseline, *pixels[0], *pixels[1]]


main()
