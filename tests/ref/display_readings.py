# Readings of the reference display of IEC 61966-2-1 by closed form: 80 cd/m2 of white over 0.4037 of grey black (0.2 and the
# veil of 64 lux on 1 %), each XYZ off by up to 0.5 % by a fixed pattern, as a meter might be. Writes tests/data/display_readings.csv.
import math
from macbeth_print import apply, inverse
def column(x, y): return [x, y, 1 - x - y]
def matrix(primaries, w):
    m = [list(r) for r in zip(*[column(*p) for p in primaries])]
    s = apply(inverse(m), [c / w[1] for c in column(*w)])
    return [[p*q for p, q in zip(row, s)] for row in m]
white = (.3127, .3290)
m = matrix([(.64, .33), (.30, .60), (.15, .06)], white)
veil = 64 * 0.01 / math.pi
black = 0.2 + veil
decode = lambda v: v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4
ramp = [51, 102, 153, 204, 255]
codes = [(0, 0, 0)] + [(v, v, v) for v in [17, 34] + ramp] + [(v, 0, 0) for v in ramp] + [(0, v, 0) for v in ramp]
codes += [(0, 0, v) for v in ramp] + [(255, 255, 0), (255, 0, 255), (0, 255, 255), (200, 100, 50), (60, 120, 180)]
with open("tests/data/display_readings.csv", "w") as out:
    print("# Made by tests/ref/display_readings.py: the srgb display, off by up to 0.5 %.\nr,g,b,x,y,Y", file=out)
    for i, code in enumerate(codes):
        light = apply(m, [decode(c / 255) for c in code])
        off = lambda k: 1 + 0.005 * math.sin(7.3 * i + 2.1 * k)
        X = [(light[k] * (80 - 0.2) + black * column(*white)[k] / white[1]) * off(k) for k in range(3)]
        print(*code, "%.5f" % (X[0] / sum(X)), "%.5f" % (X[1] / sum(X)), "%.5g" % X[1], sep=",", file=out)
