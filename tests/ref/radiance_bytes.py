#!/usr/bin/env python3
"""Pixels as Radiance 6.0 codes them (rcomb, ra_xyze, ra_rgbe of pyradiance 1.3.1 on the path): writes ../data/radiance_bytes.*.

floats: RGB in W/sr/m2; rgbe: rcomb -fc of them; xyze: ra_xyze of that; flat: ra_rgbe of that; spectra.lux, .hsr: 18 bands and
rcomb -fc of them. Runs and ramps, whole powers of two, zeros, six decades of noise. History and dates are left out."""
import pathlib, subprocess, tempfile
import numpy as np

rng = np.random.default_rng(2001)
W, H = 40, 12
P = (10 ** rng.uniform(-4, 4, (H, W, 3))).astype("<f4")
P[0] = 1.0
P[1] = np.float32(0.01) * np.arange(W)[:, None]
P[2, ::7] = 0
P[3] = 2.0 ** rng.integers(-5, 5, (W, 3))
P[4:8, :20] = P[4:8, :1]
P[8, :, 1:] = 0
S = (10 ** rng.uniform(-3, 2, (3, 5, 18))).astype("<f4")
out = pathlib.Path(__file__).parent.parent / "data"
floats = f"#?RADIANCE\nNCOMP=3\nFORMAT=float\n\n-Y {H} +X {W}\n".encode() + P.tobytes()
bands = (
    "#?RADIANCE\nNCOMP=18\nWAVELENGTH_SPLITS= 780 588 480 380\nFORMAT=float\n\n-Y 3 +X 5\n".encode() + S.tobytes()
)


def pixels(picture):
    at = picture.index(b"\n\n") + 2
    return picture[picture.index(b"\n", at) + 1 :]


def bare(keys, size, data):
    return f"#?RADIANCE\n{keys}\n\n{size}\n".encode() + data


with tempfile.TemporaryDirectory() as folder:
    def run(command, data):
        path = pathlib.Path(folder) / "in"
        path.write_bytes(data)
        return pixels(subprocess.run([*command, path], capture_output=True, check=True).stdout)

    size = f"-Y {H:8} +X {W:8}"
    rgbe = bare("FORMAT=32-bit_rle_rgbe", size, run(["rcomb", "-fc"], floats))
    (out / "radiance_bytes.lux").write_bytes(floats)
    (out / "radiance_bytes.rgbe").write_bytes(rgbe)
    xyze = run(["ra_xyze"], rgbe)
    (out / "radiance_bytes.xyze").write_bytes(bare("EXPOSURE=5.5866e-03\nFORMAT=32-bit_rle_xyze", size, xyze))
    (out / "radiance_bytes.flat").write_bytes(bare("FORMAT=32-bit_rle_rgbe", size, run(["ra_rgbe"], rgbe)))
    hsr = run(["rcomb", "-fc"], bands)
    (out / "radiance_spectra.lux").write_bytes(bands)
    keys = "NCOMP=18\nWAVELENGTH_SPLITS= 780 588 480 380\nFORMAT=Radiance_spectra"
    (out / "radiance_spectra.hsr").write_bytes(bare(keys, "-Y        3 +X        5", hsr))
