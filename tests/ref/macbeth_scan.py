# The chart as a scanner of Radiance's primaries sees it, picture value = light^(1/1.2), for macbethcal: 120 x 80 flat RGBE to
# standard output. macbethcal drops the name of its input into the file it makes.
import math
import sys
from macbeth_print import MB, apply, inverse, matrix
standard = inverse(matrix([(.64, .33), (.29, .60), (.15, .06)]))
n = list(map(float, MB.split()))
width, height = 120, 80
def rgbe(c):
    m, e = math.frexp(max(c))
    return bytes([int(x * 256 / 2**e) for x in c] + [e + 128])
patches = []
for i in range(24):
    x, y, Y = n[3*i:3*i+3]
    light = apply(standard, [x*Y/y, Y, (1-x-y)*Y/y])
    patches.append(rgbe([max(c, 1e-4) ** (1 / 1.2) for c in light]))
out = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width)
for row in range(height):
    for column in range(width):
        i = min(5, max(0, int((column - .029*width) / (.942*width) * 6)))
        j = min(3, max(0, int((row - .044*height) / (.9*height) * 4)))
        out += patches[6*j + i]
sys.stdout.buffer.write(out)
