"""Renders pictures with Blender's Cycles, for tools/bench. Runs inside Blender:

blender -b --factory-startup -P cycles.py -- JSON|@FILE
JSON is a job and FILE holds a list of jobs:
{"asset", "output", "size", "samples", "threads", "env" or null, "sun": bool, "fov": degrees}
"""
import json
import math
import sys
import time

import numpy

# Debian 12's Blender 3.4 uses a name that NumPy 1.24 removed.
if not hasattr(numpy, "bool"):
    numpy.bool = bool

import bpy  # noqa: E402
from mathutils import Vector  # noqa: E402


def bounds():
    corners = [o.matrix_world @ Vector(c) for o in bpy.context.scene.objects
               if o.type == "MESH" for c in o.bound_box]
    return (Vector(min(c[i] for c in corners) for i in range(3)),
            Vector(max(c[i] for c in corners) for i in range(3)))


def place_camera(scene, fov):
    """Sightline's fitted camera, turned from y up to Blender's z up."""
    low, high = bounds()
    centre, radius = (low + high) / 2, (high - low).length / 2
    direction = Vector((0.6, -0.8, 0.35)).normalized()
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = centre + direction * radius / math.sin(math.radians(22.5))
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    camera.data.sensor_fit, camera.data.angle = "VERTICAL", math.radians(fov)
    camera.data.clip_end = 100 * radius
    scene.collection.objects.link(camera)
    scene.camera = camera


def light(scene, job):
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    if job["env"]:
        picture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(job["env"])
        world.node_tree.links.new(picture.outputs["Color"], background.inputs["Color"])
    else:
        background.inputs["Color"].default_value = (0, 0, 0, 1)
    if job["sun"]:
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.data.angle, sun.data.energy = 0, 3
        sun.rotation_euler = Vector((-0.6, 0.8, -1)).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(sun)


def settings(scene, job):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = job["size"]
    scene.render.filepath = job["output"]
    scene.render.image_settings.file_format = "PNG"
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = job["samples"], False, False
    cycles.max_bounces = 0 if job["sun"] else 8
    cycles.diffuse_bounces = 0
    cycles.pixel_filter_type = "BOX"


def picture(job):
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.import_scene.gltf(filepath=job["asset"])
    scene = bpy.context.scene
    for other in [o for o in scene.objects if o.type in ("LIGHT", "CAMERA")]:
        bpy.data.objects.remove(other)
    place_camera(scene, job["fov"])
    light(scene, job)
    settings(scene, job)
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    print("RENDER_SECONDS", time.perf_counter() - start)


def main():
    argument = sys.argv[sys.argv.index("--") + 1]
    if not argument.startswith("@"):
        return picture(json.loads(argument))
    with open(argument[1:], encoding="utf-8") as file:
        jobs = json.load(file)
    for job in jobs:
        try:
            picture(job)
        except Exception as error:  # an asset that Blender cannot read must not stop the others
            print("SKIPPED", job["asset"], error)
        bpy.ops.wm.read_factory_settings(use_empty=True)


main()
