#!/usr/bin/env python3
"""Renders one of our scenes with Mitsuba 3: mitsuba_scene.py SCENE OUT [options]; `make bench-render` calls it.

Reads the scene's TOML and the tables of spectra/ as luxpipe does, for what the benchmark's scenes use: perspective cameras,
quads, spheres, PLY meshes and boxes of a medium, diffuse materials, lights by luminance or radiance, wavelengths from 380 to 780 nm. OUT gets
raw float32, chunk after chunk, [row][column][channel]: XYZ in cd/m2, or with --bands that many bands, the short end first.
A chunk is rendered and dropped before the clock starts, so that neither the scene nor the compiler counts; chunks with new
seeds follow until --cpu seconds of all threads together have passed. Standard output gets one line: chunks, channels, paths a
pixel and chunk, CPU seconds.
"""

import argparse
import struct
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RANGE = (380.0, 780.0)
K_M = 683.0
# Mitsuba divides the integral of radiance x observer by this.
MITSUBA_XYZ = 106.7502594


def table(path):
    rows = [l.split(",") for l in Path(path).read_text().splitlines() if l and l[0] in "0123456789"]
    return np.array(rows, float)


def spectrum(value, folder):
    """A number, or points [wavelength, value]."""
    if isinstance(value, (int, float)):
        return float(value)
    if isinstance(value, list):
        return np.array(value, float)
    names = [ROOT / "spectra" / f"{value}.csv", ROOT / "spectra" / f"illuminant_{value}.csv", folder / value]
    found = [n for n in names if n.is_file()]
    if not found:
        sys.exit(f"spectrum {value!r}: no such table")
    return table(found[0])


def within(points):
    """The points inside the range that counts, and its ends."""
    inside = points[(points[:, 0] > RANGE[0]) & (points[:, 0] < RANGE[1])]
    ends = [[x, np.interp(x, points[:, 0], points[:, 1], left=0, right=0)] for x in RANGE]
    return np.vstack([ends[:1], inside, ends[1:]])


def plugin(spec, scale=1.0):
    if isinstance(spec, float):
        spec = np.array([[RANGE[0], spec], [RANGE[1], spec]])
    points = within(spec)
    if not points[:, 1].any():  # Mitsuba refuses an empty distribution
        return {"type": "uniform", "value": 0.0}
    join = lambda column: ", ".join(repr(float(x)) for x in column)
    return {"type": "irregular", "wavelengths": join(points[:, 0]), "values": join(points[:, 1] * scale)}


def luminance(spec):
    y = table(ROOT / "spectra/cie1931_y.csv")
    nm = np.arange(360, 830.01, 0.5)
    light = np.interp(nm, spec[:, 0], spec[:, 1], left=0, right=0)
    return K_M * np.trapezoid(light * np.interp(nm, y[:, 0], y[:, 1]), nm)


def light(keys, folder):
    spec = spectrum(keys["spectrum"], folder)
    scale = keys["radiance"] if "radiance" in keys else keys["luminance"] / luminance(spec)
    return {"type": "area", "radiance": plugin(spec, scale)}


def medium(keys, folder):
    """A homogeneous isotropic one by extinction and albedo."""
    grid = lambda spec: plugin(spectrum(spec, folder))
    return {"type": "homogeneous", "sigma_t": grid(keys["extinction"]), "albedo": grid(keys["albedo"]), "phase": {"type": "isotropic"}}


def material(keys, folder):
    if keys.get("type") == "boundary":
        return {"type": "null"}
    diffuse = {"type": "diffuse", "reflectance": plugin(spectrum(keys.get("reflectance", 0.0), folder))}
    return {"type": "twosided", "bsdf": diffuse} if keys.get("two_sided", True) else diffuse


def write_quad(points, path):
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    body = b"".join(struct.pack("<3f", *p) for p in points)
    path.write_bytes(head.encode() + body + struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 0, 2, 3))


def shape(keys, number, folder, scratch):
    if keys["type"] == "sphere":
        return {"type": "sphere", "center": keys["center"], "radius": keys["radius"],
                "flip_normals": keys.get("inward", False)}
    if keys["type"] == "mesh":
        return {"type": "ply", "filename": str(folder / keys["file"]), "face_normals": True}
    if keys["type"] == "box":
        import mitsuba as mi

        low, high = np.array(keys["min"], float), np.array(keys["max"], float)
        to = mi.ScalarTransform4f().translate(list((low + high) / 2)).scale(list((high - low) / 2))
        return {"type": "cube", "to_world": to}
    if keys["type"] != "quad":
        sys.exit(f"shape {keys['type']!r}: not of the benchmark")
    path = scratch / f"{number}.ply"
    write_quad(keys["points"], path)
    return {"type": "ply", "filename": str(path), "face_normals": True}


def film(size, bands):
    common = {"width": size, "height": size, "rfilter": {"type": "box"}, "component_format": "float32"}
    if not bands:
        return {"type": "hdrfilm", "pixel_format": "xyz", **common}
    edges = np.linspace(*RANGE, bands + 1)
    box = lambda a, b: {"type": "irregular", "wavelengths": f"{a - 0.05}, {a + 0.05}, {b - 0.05}, {b + 0.05}",
                        "values": "0, 1, 1, 0"}
    return {"type": "specfilm", **common,
            **{f"band{i:03}": box(a, b) for i, (a, b) in enumerate(zip(edges, edges[1:]))}}


def scene(mi, path, options, scratch):
    keys = tomllib.loads(path.read_text())
    folder, camera = path.parent, keys["camera"]
    look = mi.ScalarTransform4f().look_at(camera["origin"], camera["target"], camera["up"])
    whole = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1, "rr_depth": 8} if "media" not in keys
        else {"type": "volpathmis", "max_depth": -1, "rr_depth": 16},
        "sensor": {"type": "perspective", "fov": camera["fov_deg"], "fov_axis": "x", "to_world": look,
                   "film": film(options.size, options.bands), "sampler": {"type": options.sampler, "sample_count": options.spp}},
    }
    for number, s in enumerate(keys["shape"]):
        made = shape(s, number, folder, scratch)
        bsdf = keys["materials"][s["material"]]
        made["bsdf"] = material(bsdf, folder)
        if "interior" in bsdf:
            made["interior"] = medium(keys["media"][bsdf["interior"]], folder)
        if "light" in s:
            made["emitter"] = light(keys["lights"][s["light"]], folder)
        whole[f"shape{number}"] = made
    return mi.load_dict(whole)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--variant", default="llvm_ad_spectral")
    parser.add_argument("--sampler", default="independent", choices=["independent", "multijitter"])
    parser.add_argument("--spp", type=int, default=32, help="paths a pixel in a chunk")
    parser.add_argument("--cpu", type=float, default=20)
    parser.add_argument("--bands", type=int, default=0)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    import drjit
    import mitsuba as mi

    mi.set_variant(options.variant)
    mi.set_log_level(mi.LogLevel.Error)
    if options.variant.startswith("llvm"):
        drjit.set_thread_count(options.threads)
    else:
        mi.Thread.set_thread_count(options.threads) if hasattr(mi.Thread, "set_thread_count") else None
    with tempfile.TemporaryDirectory() as scratch:
        loaded = scene(mi, options.scene.resolve(), options, Path(scratch))
    render = lambda seed: np.array(mi.render(loaded, spp=options.spp, seed=seed), np.float32)
    render(0)
    factor, chunks, start = 1.0 if options.bands else K_M * MITSUBA_XYZ, 0, time.process_time()
    with options.out.open("wb") as out:
        seconds = 0.0
        while seconds < options.cpu:
            chunks += 1
            picture = render(chunks)
            seconds = time.process_time() - start
            out.write((picture * np.float32(factor)).astype("<f4").tobytes())
    print(chunks, picture.shape[2], options.spp, f"{seconds:.3f}")


main()
