#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A mesh and a cloud of a recording, by a program that is not ours: Open3D's TSDF.

    kitchen_mesh.py RECORDING OUT    RECORDING: camera.ini, groundtruth.txt, depth/STAMP.png

writes OUT/mesh.ply (voxels of 1 cm), OUT/cloud.ply (a point every 2 cm, with normals) and OUT/poses.txt, the poses of
the images. README.md says how maps of them are scored."""

import argparse
import pathlib

import numpy as np
import open3d as o3d


def read_camera(path):
    pairs = [part.split("=") for line in path.read_text().splitlines() for part in line.split("#")[0].split()]
    return {key: value for key, value in pairs}


def pose_matrix(numbers):
    x, y, z, w = numbers[3:7] / np.linalg.norm(numbers[3:7])
    pose = np.eye(4)
    pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    pose[:3, 3] = numbers[:3]
    return pose


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("recording", type=pathlib.Path)
    arguments.add_argument("out", type=pathlib.Path)
    arguments.add_argument("--voxel", type=float, default=0.01, help="size of a voxel [m]")
    arguments.add_argument("--cloud", type=float, default=0.02, help="distance of the cloud's points [m]")
    arguments.add_argument("--farthest", type=float, default=4.0, help="largest depth that is fused [m]")
    options = arguments.parse_args()

    camera = read_camera(options.recording / "camera.ini")
    intrinsics = o3d.camera.PinholeCameraIntrinsic(int(camera["width"]), int(camera["height"]), float(camera["fx"]),
                                                   float(camera["fy"]), float(camera["cx"]), float(camera["cy"]))
    poses = np.loadtxt(options.recording / "groundtruth.txt")
    images = sorted((options.recording / "depth").glob("*.png"), key=lambda path: float(path.stem))
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        voxel_length=options.voxel, sdf_trunc=4 * options.voxel,
        color_type=o3d.pipelines.integration.TSDFVolumeColorType.NoColor)
    for image in images:
        nearest = poses[np.argmin(np.abs(poses[:, 0] - float(image.stem)))]
        depth = o3d.io.read_image(str(image))
        grey = o3d.geometry.Image(np.zeros(np.asarray(depth).shape, np.uint8))
        rgbd = o3d.geometry.RGBDImage.create_from_color_and_depth(
            grey, depth, depth_scale=float(camera["depth_scale"]), depth_trunc=options.farthest,
            convert_rgb_to_intensity=False)
        volume.integrate(rgbd, intrinsics, np.linalg.inv(pose_matrix(nearest[1:8])))

    options.out.mkdir(parents=True, exist_ok=True)
    mesh = volume.extract_triangle_mesh()
    o3d.io.write_triangle_mesh(str(options.out / "mesh.ply"), mesh)
    mesh.compute_vertex_normals()
    points = o3d.geometry.PointCloud(mesh.vertices)
    points.normals = mesh.vertex_normals
    points = points.voxel_down_sample(options.cloud)
    o3d.io.write_point_cloud(str(options.out / "cloud.ply"), points)
    np.savetxt(options.out / "poses.txt", poses, fmt="%.6f")
    print(f"{len(images)} images, {len(mesh.triangles)} triangles, {len(points.points)} points; files in {options.out}")


if __name__ == "__main__":
    main()
