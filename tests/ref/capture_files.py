"""Brackets of one synthetic scene, written by Pillow: tests/data/capture. Run in that folder: python3 ../../ref/capture_files.py

Light of a pixel at x, y of 64 x 64, in three channels:
    E = 10 ^ (-1.5 + 3 x / 63) * COLOUR[y / 16], but 1000 in the 8 x 8 block at the top right, and 0 in that at the top left.
Code = round(255 sRGB(min(E t, 1))), t = 1/60, 1/8, 1 s.
a.jpg, b.jpg (progressive), c.jpg: quality 100, no subsampling, EXIF: ExposureTime, f/4, ISO 200. short, middle, long.png: no EXIF.
a.tif, b.tif (LZW), c.tif (Deflate): no EXIF. turned.jpg: a.jpg's picture stored a quarter turned, Orientation 6.
"""
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

COLOUR = [(1, 1, 1), (1, 0.6, 0.3), (0.4, 1, 0.5), (0.3, 0.5, 1)]
SIZE = 64


def light(x, y):
    if y < 8 and x >= 56:
        return (1000, 1000, 1000)
    if y < 8 and x < 8:
        return (0, 0, 0)
    return tuple(10 ** (-1.5 + 3 * x / 63) * c for c in COLOUR[y // 16])


def srgb(v):
    return 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055


def picture(t):
    image = Image.new("RGB", (SIZE, SIZE))
    for y in range(SIZE):
        for x in range(SIZE):
            image.putpixel((x, y), tuple(int(255 * srgb(min(e * t, 1)) + 0.5) for e in light(x, y)))
    return image


def exif(t, orientation=1):
    e = Image.Exif()
    e[0x0112] = orientation
    e.get_ifd(0x8769).update({0x829A: IFDRational(1, round(1 / t)), 0x829D: IFDRational(4, 1), 0x8827: 200})
    return e


for name, png, t in [("a", "short", 1 / 60), ("b", "middle", 1 / 8), ("c", "long", 1)]:
    image = picture(t)
    image.save(f"{png}.png", optimize=True)
    image.save(f"{name}.jpg", quality=100, subsampling=0, progressive=name == "b", exif=exif(t))
    compression = {"a": None, "b": "tiff_lzw", "c": "tiff_adobe_deflate"}[name]
    image.save(f"{name}.tif", compression=compression)
turned = picture(1 / 60).transpose(Image.Transpose.ROTATE_90)
turned.save("turned.jpg", quality=100, subsampling=0, exif=exif(1 / 60, 6))
