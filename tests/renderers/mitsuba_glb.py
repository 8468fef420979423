"""Renders a .glb that aliascope wrote with Mitsuba 3: GLB OUT.exr WIDTH HEIGHT SAMPLER SAMPLES SEED THREADS.

One picture each of what shines and of every light, summed: Mitsuba would let what shines light the rest, and choose one
light of several at random, where the scenes' shading equation has neither. That has no factor 1/pi, so lights are pi
times as bright here. The background is what no surface covers.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from aliascope import scene_io
from aliascope.geometry import Frame, frame_of
from aliascope.image import write_exr
from aliascope.model import BLACK, Scene


def sensor_of(frame: Frame, scene: Scene) -> dict[str, Any]:
    place = mi.ScalarTransform4f().look_at(
        origin=frame.eye.tolist(), target=(frame.eye + frame.forward).tolist(), up=frame.up.tolist()
    )
    if frame.perspective:
        lens: dict[str, Any] = {"type": "perspective", "fov": scene.camera.vertical_fov_degrees, "fov_axis": "y"}
    else:
        lens = {"type": "orthographic"}
        place = place @ mi.ScalarTransform4f().scale([frame.half_width, frame.half_width, 1.0])
    return {**lens, "to_world": place, "near_clip": 1e-4, "far_clip": 1e6}


def toward(frame: Frame, triangles: np.ndarray) -> np.ndarray:
    """The triangles, each wound so that its normal is toward the viewer: emitters shine to that side alone."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    away = triangles[:, 0] - frame.eye if frame.perspective else np.broadcast_to(frame.forward, normals.shape)
    turned = (normals * away).sum(axis=1) > 0.0
    return np.where(turned[:, np.newaxis, np.newaxis], triangles[:, ::-1], triangles)


def shapes_of(scene: Scene, frame: Frame, shining: bool) -> Iterator[tuple[str, Any]]:
    """Each surface as it shines, reflecting nothing, or as it reflects, without shining."""
    for number, surface in enumerate(scene.surfaces):
        material = scene.materials[surface.material]
        corners = toward(frame, surface.triangles).reshape(-1, 3)
        properties = mi.Properties()
        colour = BLACK if shining else material.albedo
        matt = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}
        properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": matt})
        if shining and material.emission != BLACK:
            glow = {"type": "rgb", "value": list(material.emission)}
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": glow})
        mesh = mi.Mesh(f"surface{number}", len(corners), len(corners) // 3, props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = corners.ravel().astype(np.float32)
        parameters["faces"] = np.arange(len(corners), dtype=np.uint32)
        parameters.update()
        yield f"surface{number}", mesh


def lights_of(scene: Scene) -> Iterator[dict[str, Any]]:
    for light in scene.lights:
        power = {"type": "rgb", "value": [np.pi * channel for channel in light.intensity]}
        if light.type == "point":
            yield {"type": "point", "position": list(light.position), "intensity": power}
        else:
            yield {"type": "directional", "direction": list(light.direction), "irradiance": power}


def main(glb: str, out: str, width: int, height: int, sampler: str, samples: int, seed: int, threads: int) -> None:
    mi.set_variant("scalar_rgb")
    dr.set_thread_count(threads)
    scene = scene_io.load(glb).scene
    film = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "rgba",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    frame = frame_of(scene, (width, height))
    sensor = sensor_of(frame, scene)
    # Each has its sampler afresh, so that the samples of all lie at the same places.
    parts = [({"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}, dict(shapes_of(scene, frame, True)))]
    lit = dict(shapes_of(scene, frame, False)) if scene.lights else {}
    direct = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
    parts += [(direct, {**lit, "light": light}) for light in lights_of(scene)]
    total, seconds, taken = np.zeros((height, width, 3)), 0.0, samples
    for number, (integrator, contents) in enumerate(parts):
        pattern = mi.load_dict({"type": sampler, "sample_count": samples, "seed": seed % 2**32})
        taken = pattern.sample_count()
        view = {**sensor, "film": film, "sampler": pattern}
        built = mi.load_dict({"type": "scene", "integrator": integrator, "sensor": view, **contents})
        begun = time.process_time()
        picture = np.array(mi.render(built, seed=seed % 2**32, spp=taken), dtype=np.float64)
        seconds += time.process_time() - begun
        total += picture[:, :, :3]
        if number == 0:
            total += (1.0 - picture[:, :, 3:]) * np.array(scene.view.background)
    write_exr(Path(out), total.astype(np.float32), {})
    print(f"samples a pixel: {taken}\nCPU seconds: {seconds:.6f}")


if __name__ == "__main__":
    main(*sys.argv[1:3], *map(int, sys.argv[3:5]), sys.argv[5], *map(int, sys.argv[6:9]))
