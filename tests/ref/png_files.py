#!/usr/bin/env python3
"""PNG files of other programs for tests/png.rs: Pillow, and the libpng and LittleCMS that its wheel holds.

    python png_files.py ../data/png
"""
import ctypes as c
import glob
import os
import sys

import numpy as np
import PIL
from PIL import Image, ImageCms

out = sys.argv[1]
libs = os.path.join(os.path.dirname(os.path.dirname(PIL.__file__)), "pillow.libs")
libc = c.CDLL(None)
cms = c.CDLL(glob.glob(libs + "/liblcms2*")[0])
png = c.CDLL(glob.glob(libs + "/libpng16*")[0])
for f in (libc.fopen, cms.cmsBuildParametricToneCurve, cms.cmsCreateRGBProfile, png.png_create_write_struct, png.png_create_info_struct):
    f.restype = c.c_void_p

# A palette of 4 bits, one entry transparent; pixel i has colour i mod 5.
im = Image.new("P", (5, 3))
im.putpalette([255, 0, 0, 0, 128, 0, 0, 0, 255, 200, 100, 50, 10, 20, 30])
im.putdata([i % 5 for i in range(15)])
im.save(f"{out}/palette.png", bits=4, transparency=2)

# Grey of 16 bits: pixel i has code 5957 i.
Image.fromarray((np.arange(12, dtype=np.uint32) * 5957).astype(np.uint16).reshape(3, 4)).save(f"{out}/grey16.png")

# Grey of 1 bit: a chessboard, black first.
Image.fromarray((np.indices((4, 9)).sum(0) % 2 * 255).astype(np.uint8)).convert("1").save(f"{out}/grey1.png")

# Display P3 by LittleCMS, and a gamma of 1.8 with Adobe's primaries as version 2; colours as below.
class XYY(c.Structure):
    _fields_ = [("x", c.c_double), ("y", c.c_double), ("Y", c.c_double)]

def profile(primaries, white, kind, parameters, version, name):
    curve = c.c_void_p(cms.cmsBuildParametricToneCurve(None, kind, (c.c_double * len(parameters))(*parameters)))
    triple = (XYY * 3)(*[XYY(x, y, 1) for x, y in primaries])
    p = c.c_void_p(cms.cmsCreateRGBProfile(c.byref(XYY(*white, 1)), triple, (c.c_void_p * 3)(curve, curve, curve)))
    cms.cmsSetProfileVersion(p, c.c_double(version))
    size = c.c_uint32()
    cms.cmsSaveProfileToMem(p, None, c.byref(size))
    data = c.create_string_buffer(size.value)
    cms.cmsSaveProfileToMem(p, data, c.byref(size))
    return data.raw[: size.value]

colours = np.array([[[255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128], [200, 50, 120], [1, 2, 3]]], np.uint8)
srgb = [2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045]
p3 = profile([(0.68, 0.32), (0.265, 0.69), (0.15, 0.06)], (0.3127, 0.329), 4, srgb, 4.3, "p3")
adobe = profile([(0.64, 0.33), (0.21, 0.71), (0.15, 0.06)], (0.3127, 0.329), 1, [1.8], 2.1, "adobe")
Image.fromarray(colours).save(f"{out}/p3_icc.png", icc_profile=p3)
Image.fromarray(colours).save(f"{out}/adobe_icc2.png", icc_profile=adobe)

# RGBA of 8 bits, interlaced, gAMA and cHRM alone: channel k of pixel (x, y) is (37 x + 59 y + 83 k) mod 256, alpha 255.
w, h = 13, 9
version = c.c_char_p(b"1.6.0")
s = c.c_void_p(png.png_create_write_struct(version, None, None, None))
i = c.c_void_p(png.png_create_info_struct(s))
file = c.c_void_p(libc.fopen(f"{out}/interlaced.png".encode(), b"wb"))
png.png_init_io(s, file)
png.png_set_IHDR(s, i, w, h, 8, 6, 1, 0, 0)
png.png_set_gAMA(s, i, c.c_double(1 / 1.8))
png.png_set_cHRM(s, i, *[c.c_double(n) for n in (0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06)])
x, y, k = np.meshgrid(range(w), range(h), range(4), indexing="ij")
pixels = ((37 * x + 59 * y + 83 * k) % 256).transpose(1, 0, 2).astype(np.uint8).copy()
pixels[:, :, 3] = 255
rows = (c.c_void_p * h)(*[pixels[j].ctypes.data for j in range(h)])
png.png_set_rows(s, i, rows)
png.png_write_png(s, i, 0, None)
libc.fclose(file)

# What LittleCMS makes of the colours: Lab at D50, relative colorimetric.
def lab(data, codes):
    import io
    source = ImageCms.ImageCmsProfile(io.BytesIO(data))
    cms.cmsCreateLab4Profile.restype = cms.cmsOpenProfileFromMem.restype = cms.cmsCreateTransform.restype = c.c_void_p
    a = c.c_void_p(cms.cmsOpenProfileFromMem(data, len(data)))
    b = c.c_void_p(cms.cmsCreateLab4Profile(None))
    RGB_16, LAB_DBL = (4 << 16) | (3 << 3) | 2, (1 << 22) | (10 << 16) | (3 << 3) | 0
    t = c.c_void_p(cms.cmsCreateTransform(a, c.c_uint32(RGB_16), b, c.c_uint32(LAB_DBL), c.c_uint32(1), c.c_uint32(0x40 | 0x100)))
    codes = np.ascontiguousarray(codes.reshape(-1, 3).astype(np.uint16))
    result = np.zeros(codes.shape)
    cms.cmsDoTransform(t, codes.ctypes.data_as(c.c_void_p), result.ctypes.data_as(c.c_void_p), c.c_uint32(len(codes)))
    return result

if __name__ == "__main__":
    np.set_printoptions(suppress=True, precision=3)
    names = sys.argv[2:] or [f"{out}/p3_icc.png", f"{out}/adobe_icc2.png"]
    for n in names:
        print(n)
        for code, value in zip(colours[0], lab(Image.open(n).info["icc_profile"], colours.astype(np.uint16) * 257)):
            print(code, value)
