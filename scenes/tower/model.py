#!/usr/bin/env python3
"""Writes the meshes of scenes/tower.toml beside itself, one file a material: python3 scenes/tower/model.py

Metres; x right, y out of the window, z up; the tower stands on the origin. All of it is our own modelling."""

from math import cos, pi, radians, sin, sqrt, tan
from pathlib import Path

FACES = {}

FLOOR, SILL, HEAD, CEILING = 24.0, 24.7, 27.05, 27.3
IN, OUT = 4.5, 5.05  # from the axis to a side of the octagon, at the sill and at the head
DESK = 24.62


def face(name, *points):
    FACES.setdefault(name, []).append(points)


def box(name, a, b, move=lambda p: p):
    """A box from a to b, each corner moved."""
    at = lambda x, y, z: move(((a[0], b[0])[x], (a[1], b[1])[y], (a[2], b[2])[z]))
    for q in (
        [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)], [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
        [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)], [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)],
        [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)], [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    ):
        face(name, *[at(*c) for c in q])


def loft(name, rings, ends=True):
    """Rings of equally many points, joined."""
    for r, s in zip(rings, rings[1:]):
        n = len(r)
        for i in range(n):
            face(name, r[i], r[(i + 1) % n], s[(i + 1) % n], s[i])
    if ends:
        face(name, *reversed(rings[0]))
        face(name, *rings[-1])


def side(degrees):
    """Places beside a side of the octagon: along it to the right, out from the axis, up."""
    c, s = cos(radians(degrees)), sin(radians(degrees))
    return lambda p: (p[0] * s + p[1] * c, -p[0] * c + p[1] * s, p[2])


# --- the cab ---------------------------------------------------------------------------------------------------------

def octagon(apothem, z):
    r = apothem / cos(pi / 8)
    return [(r * cos(pi / 8 + k * pi / 4), r * sin(pi / 8 + k * pi / 4), z) for k in range(8)]


def post(name, foot, head, w):
    ring = lambda p: [(p[0] - w, p[1] - w, p[2]), (p[0] + w, p[1] - w, p[2]), (p[0] + w, p[1] + w, p[2]), (p[0] - w, p[1] + w, p[2])]
    loft(name, [ring(foot), ring(head)])


def screen(move, x, d, z, w, h, content, lean=0.05):
    """A monitor whose picture faces the room: a dark case and rectangles of light, each (left, bottom, right, top, light)
    in parts of the picture."""
    at = lambda u, v, off: move((x + (u - 0.5) * w, d + lean * v - off, z + v * h))
    rim = 0.018
    case = lambda p: move((p[0], p[1] + lean * (p[2] - z) / h, p[2]))
    box("black", (x - w / 2 - rim, d + 0.003, z - rim), (x + w / 2 + rim, d + 0.045, z + h + rim), case)
    box("black", (x - 0.04, d + 0.05, DESK), (x + 0.04, d + 0.08, z + 0.1), move)
    box("black", (x - 0.13, d - 0.04, DESK), (x + 0.13, d + 0.14, DESK + 0.012), move)
    for i, (a, b, c, e, light) in enumerate(content):
        off = 0.0006 * (i + 1)
        face("screen_" + light, at(a, b, off), at(c, b, off), at(c, e, off), at(a, e, off))


def radar(n):
    """A radar picture: rings, tracks, a list."""
    content = [(0, 0, 1, 1, "dark"), (0, 0.94, 1, 1, "blue")]
    for r in (0.16, 0.3, 0.42):
        for k in range(28):
            t = 2 * pi * k / 28
            u, v = 0.38 + 0.72 * r * cos(t), 0.47 + r * sin(t)
            content.append((u - 0.006, v - 0.01, u + 0.006, v + 0.01, "green"))
    for k in range(13):
        u, v = 0.08 + (k * 0.377 + n * 0.21) % 0.6, 0.1 + (k * 0.617 + n * 0.37) % 0.76
        content.append((u, v, u + 0.016, v + 0.028, "white"))
        content.append((u + 0.025, v + 0.03, u + 0.085, v + 0.05, "green"))
        content.append((u + 0.025, v + 0.06, u + 0.07, v + 0.08, "green"))
    content.append((0.76, 0.05, 0.98, 0.9, "grey"))
    for k in range(11):
        content.append((0.78, 0.82 - 0.07 * k, 0.78 + 0.09 + 0.09 * ((k * 7 + n) % 3) / 2, 0.85 - 0.07 * k, "white"))
    return content


def list_of_flights(n):
    """A bright window with lines of text on it."""
    content = [(0, 0, 1, 1, "blue"), (0.03, 0.05, 0.97, 0.88, "white"), (0.03, 0.9, 0.5, 0.96, "grey")]
    for k in range(9):
        u = 0.06
        for j in range(5):
            w = 0.06 + 0.03 * ((k * 5 + j * 3 + n) % 4)
            content.append((u, 0.78 - 0.08 * k, u + w, 0.815 - 0.08 * k, "dark" if (k + j + n) % 5 else "red"))
            u += 0.18
    return content


def weather(n):
    """Coloured fields on a dark map, and dials."""
    content = [(0, 0, 1, 1, "dark")]
    for k in range(22):
        u, v = 0.05 + (k * 0.283 + n * 0.3) % 0.5, 0.08 + (k * 0.431) % 0.75
        w = 0.04 + 0.02 * (k % 4)
        content.append((u, v, u + w, v + 1.1 * w, ("green", "blue", "amber", "green", "red")[k % 5]))
    for k in range(4):
        content.append((0.68, 0.08 + 0.22 * k, 0.95, 0.25 + 0.22 * k, "grey"))
        content.append((0.71, 0.13 + 0.22 * k, 0.71 + 0.05 * (1 + (k + n) % 4), 0.19 + 0.22 * k, "white"))
    return content


def cab():
    face("carpet", *octagon(IN + 0.2, FLOOR))
    face("ceiling", *reversed(octagon(OUT + 0.6, CEILING)))
    face("roof", *octagon(OUT + 0.9, CEILING + 0.25))
    loft("roof", [octagon(OUT + 0.6, CEILING), octagon(OUT + 0.9, CEILING + 0.02), octagon(OUT + 0.9, CEILING + 0.25)], ends=False)
    low, high = octagon(IN, SILL), octagon(OUT, HEAD)
    for k in range(8):
        middle = (k + 1) * 45
        move = side(middle)
        half_in, half_out = IN * tan(pi / 8), OUT * tan(pi / 8)
        quad = lambda name, a, b, c, d: face(name, *[move(p) for p in (a, b, c, d)])
        quad("wall", (-half_in, IN, FLOOR), (half_in, IN, FLOOR), (half_in, IN, SILL), (-half_in, IN, SILL))
        box("sill", (-half_in, IN - 0.12, SILL - 0.03), (half_in, IN + 0.06, SILL), move)
        quad("ceiling", (-half_out, OUT, HEAD), (half_out, OUT, HEAD), (half_out, OUT, CEILING), (-half_out, OUT, CEILING))
        if middle in (225, 270, 315):  # the stair and the blinds behind the eye
            quad("blinds", (-half_in, IN, SILL), (half_in, IN, SILL), (half_out, OUT, HEAD), (-half_out, OUT, HEAD))
        elif middle != 90:
            post("frame", move((0, IN, SILL)), move((0, OUT, HEAD)), 0.022)
    for foot, head in zip(low, high):
        post("frame", foot, head, 0.055)
    for degrees in (45, 90, 135):
        move = side(degrees)
        half = 3.3 * tan(pi / 8)
        wide = IN * tan(pi / 8)
        top = [move(p) for p in ((-half, 3.3, DESK), (half, 3.3, DESK), (wide, IN, DESK), (-wide, IN, DESK))]
        face("desk", *top)
        front = [move(p) for p in ((-half, 3.3, DESK - 0.05), (half, 3.3, DESK - 0.05), (half, 3.3, DESK), (-half, 3.3, DESK))]
        face("trim", *front)
        knee = 3.55 * tan(pi / 8)
        below = [move(p) for p in ((-knee, 3.55, FLOOR), (knee, 3.55, FLOOR), (knee, 3.55, DESK), (-knee, 3.55, DESK))]
        face("wall", *below)
    things()


def things():
    """What stands on the desks and hangs from the ceiling."""
    front, left, right = side(90), side(135), side(45)
    for i, (x, content) in enumerate([(-1.36, list_of_flights(0)), (-0.68, radar(0)), (0.0, radar(1)), (0.68, weather(1)), (1.36, list_of_flights(3))]):
        screen(front, x, 4.0, 24.74, 0.58, 0.35, content)
        box("black", (x - 0.2, 3.52, DESK), (x + 0.2, 3.66, DESK + 0.02), front)
    for move, n in ((left, 2), (right, 5)):
        for x, content in ((-0.95, radar(n)), (-0.25, list_of_flights(n)), (0.45, weather(n)), (1.1, radar(n + 1))):
            screen(move, x, 4.0, 24.74, 0.58, 0.35, content)
    # Hung below the window's head.
    for x, content in ((-1.25, weather(2)), (1.25, radar(4))):
        hung = lambda p, x=x: (p[0], p[1], p[2])
        at = lambda u, v, off: (x + (u - 0.5) * 0.62, 4.35 - 0.12 * v - off, 26.62 + v * 0.36)
        box("black", (x - 0.33, 4.31, 26.6), (x + 0.33, 4.42, 27.0), hung)
        box("black", (x - 0.02, 4.36, 27.0), (x + 0.02, 4.4, CEILING), hung)
        for i, (a, b, c, e, light) in enumerate(content):
            off = 0.05 + 0.0006 * (i + 1)
            face("screen_" + light, at(a, b, off), at(c, b, off), at(c, e, off), at(a, e, off))
    # Bays of flight strips, paper, mugs, a telephone.
    for x, columns in ((-1.02, 2), (0.34, 2)):
        for c in range(columns):
            for k in range(5):
                a = (x + 0.17 * c - 0.16, 3.36 + 0.055 * k, DESK + 0.006 + 0.008 * k)
                name = ("paper", "strip_blue", "paper", "strip_amber")[(k + c * 3 + int(x > 0)) % 4]
                box(name, a, (a[0] + 0.155, a[1] + 0.042, a[2] + 0.006))
    box("paper", (1.02, 3.4, DESK), (1.23, 3.69, DESK + 0.004))
    box("paper", (-0.52, 3.37, DESK), (-0.31, 3.66, DESK + 0.003))
    ring = lambda z, r, x, y: [(x + r * cos(2 * pi * k / 16), y + r * sin(2 * pi * k / 16), z) for k in range(16)]
    loft("mug", [ring(DESK, 0.04, 0.98, 3.78), ring(DESK + 0.1, 0.043, 0.98, 3.78)], ends=False)
    face("black", *ring(DESK + 0.085, 0.042, 0.98, 3.78))
    loft("mug_red", [ring(DESK, 0.04, -1.04, 3.76), ring(DESK + 0.1, 0.043, -1.04, 3.76)], ends=False)
    face("black", *ring(DESK + 0.085, 0.042, -1.04, 3.76))
    box("trim", (0.02, 3.4, DESK), (0.2, 3.6, DESK + 0.05))
    box("black", (0.03, 3.4, DESK + 0.05), (0.08, 3.6, DESK + 0.085))
    # Two chairs.
    for x, y in ((-0.68, 2.62), (1.0, 2.7)):
        box("chair", (x - 0.25, y, 24.42), (x + 0.25, y + 0.08, 25.02))
        box("chair", (x - 0.25, y, 24.4), (x + 0.25, y + 0.5, 24.48))
        box("black", (x - 0.04, y + 0.2, FLOOR), (x + 0.04, y + 0.28, 24.4))
    for x in (-1.6, 0.0, 1.6):
        for y in (1.7, 3.4):
            z = CEILING - 0.01
            face("lamps", (x - 0.15, y - 0.15, z), (x - 0.15, y + 0.15, z), (x + 0.15, y + 0.15, z), (x + 0.15, y - 0.15, z))


# --- aircraft --------------------------------------------------------------------------------------------------------

STATIONS = [  # from nose to tail: x, radius, height of the middle
    (18.9, 0.06, 3.25), (18.5, 0.55, 3.28), (17.8, 0.98, 3.35), (16.6, 1.42, 3.45), (15.0, 1.78, 3.55), (13.0, 1.95, 3.6),
    (10.0, 1.98, 3.6), (0.0, 1.98, 3.6), (-7.5, 1.98, 3.6), (-11.0, 1.8, 3.75), (-14.0, 1.38, 4.1), (-16.8, 0.85, 4.5), (-19.2, 0.25, 4.85),
]


def body_at(x):
    for (a, ra, za), (b, rb, zb) in zip(STATIONS, STATIONS[1:]):
        if b <= x <= a:
            t = (a - x) / (a - b)
            return ra + t * (rb - ra), za + t * (zb - za)
    return STATIONS[-1][1:]


def plane(x, y, heading, accent, scale):
    c, s = cos(radians(heading)) * scale, sin(radians(heading)) * scale
    put = lambda p: (x + p[0] * c - p[1] * s, y + p[0] * s + p[1] * c, 0.1 + p[2] * scale)
    n = 18
    ring = lambda px, r, z, grow=1.0: [put((px, r * grow * cos(2 * pi * k / n), z + r * grow * sin(2 * pi * k / n))) for k in range(n)]
    loft("plane_white", [ring(*st) for st in STATIONS])
    on = lambda px, angle, off=0.012: (lambda r, z: put((px, (r + off) * cos(angle), z + (r + off) * sin(angle))))(*body_at(px))
    for right in (0, 1):
        turn = lambda a: pi - a if right else a
        low, high = turn(0.16), turn(0.36)
        px = 14.4
        while px > -12.5:
            face("plane_dark", on(px, low), on(px - 0.36, low), on(px - 0.36, high), on(px, high))
            px -= 0.78
        for a, b in ((17.5, 16.9), (16.8, 16.1)):  # the windows of the cockpit
            face("plane_dark", on(a, turn(0.55), 0.03), on(b, turn(0.5), 0.03), on(b, turn(1.0), 0.03), on(a, turn(1.05), 0.03))
        stripe = [14.6 - 2.05 * k for k in range(15)]
        for a, b in zip(stripe, stripe[1:]):
            face(accent, on(a, turn(-0.22)), on(b, turn(-0.22)), on(b, turn(0.02)), on(a, turn(0.02)))
        sign = -1 if right else 1
        wing = lambda px, py, pz, thick, chord: [put((px, sign * py, pz)), put((px - 0.35 * chord, sign * py, pz + thick)), put((px - chord, sign * py, pz)), put((px - 0.35 * chord, sign * py, pz - 0.4 * thick))]
        loft("plane_grey", [wing(4.6, 1.3, 2.55, 0.45, 7.4), wing(0.4, 6.2, 3.0, 0.3, 4.5), wing(-6.1, 17.0, 4.1, 0.1, 1.7)])
        face(accent, *[put((px, sign * py, pz)) for px, py, pz in ((-6.1, 17.0, 4.1), (-7.8, 17.0, 4.1), (-8.6, 17.35, 6.2), (-7.6, 17.35, 6.2))])
        loft("plane_grey", [wing(-14.3, 0.6, 4.9, 0.2, 3.8), wing(-17.6, 6.1, 5.4, 0.06, 1.5)])
        m = 14
        pod = lambda px, r, z: [put((px, sign * 5.75 + r * cos(2 * pi * k / m), z + r * sin(2 * pi * k / m))) for k in range(m)]
        loft(accent, [pod(4.6, 0.95, 1.75), pod(4.2, 1.12, 1.75), pod(2.0, 1.12, 1.78), pod(0.4, 0.75, 1.85)], ends=False)
        face("plane_dark", *pod(4.35, 0.93, 1.75))
        face("plane_dark", *pod(0.5, 0.72, 1.85))
        box("plane_grey", (0.5, sign * 5.75 - 0.15, 2.5), (3.2, sign * 5.75 + 0.15, 3.1), put)
        box("plane_dark", (-1.9, sign * 3.6 - 0.35, 0), (-0.7, sign * 3.6 + 0.35, 1.2), put)
        box("plane_grey", (-1.4, sign * 3.6 - 0.1, 1.2), (-1.2, sign * 3.6 + 0.1, 2.6), put)
    box("plane_dark", (12.3, -0.28, 0), (13.1, 0.28, 0.85), put)
    box("plane_grey", (12.6, -0.08, 0.8), (12.8, 0.08, 1.9), put)
    fin = lambda px, pz, chord, thick: [put((px, 0, pz)), put((px - 0.35 * chord, thick, pz)), put((px - chord, 0, pz)), put((px - 0.35 * chord, -thick, pz))]
    loft(accent, [fin(-11.0, 5.3, 7.0, 0.22), fin(-12.6, 6.2, 5.4, 0.2), fin(-16.9, 11.6, 2.7, 0.08)])


# --- the field -------------------------------------------------------------------------------------------------------

def flat(name, x0, y0, x1, y1, z):
    face(name, (x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z))


def ribbon(name, points, w, z):
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        length = sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        ox, oy = -(by - ay) / length * w / 2, (bx - ax) / length * w / 2
        face(name, (ax - ox, ay - oy, z), (bx - ox, by - oy, z), (bx + ox, by + oy, z), (ax + ox, ay + oy, z))


def ridge(name, y, foot, x0, x1, step, height):
    """A slope that rises from `foot` metres before y to a skyline of `height(x)`."""
    xs = [x0 + step * k for k in range(int((x1 - x0) / step) + 1)]
    for a, b in zip(xs, xs[1:]):
        face(name, (a, y - foot, 0), (b, y - foot, 0), (b, y, height(b)), (a, y, height(a)))


def field():
    flat("grass", -2100, -2100, 2100, 2100, 0.0)
    flat("dry_grass", -900, 232, 900, 290, 0.03)
    flat("dry_grass", -900, 452, 900, 560, 0.03)
    flat("concrete", -260, 20, 260, 186, 0.05)
    for k in range(-12, 13):
        flat("joint", 20 * k - 0.12, 20, 20 * k + 0.12, 186, 0.07)
    for k in range(1, 8):
        flat("joint", -260, 20 + 20 * k - 0.12, 260, 20 + 20 * k + 0.12, 0.07)
    flat("asphalt", -900, 200, 900, 226, 0.06)
    ribbon("yellow", [(-900, 213), (900, 213)], 0.7, 0.09)
    for x in (-150, 40, 205):
        flat("asphalt", x - 11, 180, x + 11, 210, 0.055)
        flat("asphalt", x - 11, 220, x + 11, 345, 0.055)
        ribbon("yellow", [(x, 170), (x, 350)], 0.7, 0.095)
    ribbon("yellow", [(-250, 172), (250, 172)], 0.7, 0.09)
    for x in (-42, 8, 58):
        ribbon("yellow", [(x, 100), (x, 140), (x + 4, 152), (x + 14, 163), (x + 30, 172)], 0.6, 0.09)
        ribbon("marking", [(x - 20, 98), (x - 20, 146)], 0.3, 0.09)
        ribbon("yellow", [(x - 3, 100), (x + 3, 100)], 0.5, 0.1)
    flat("runway", -900, 330, 900, 375, 0.08)
    for y in (332, 373):
        flat("marking", -900, y - 0.6, 900, y + 0.6, 0.11)
    for k in range(-15, 16):
        flat("marking", 60 * k - 15, 352, 60 * k + 15, 353.2, 0.11)
    for k in range(4):
        for sign in (-1, 1):
            flat("marking", -235, 352.5 + sign * (5 + 4 * k) - 1.2, -190, 352.5 + sign * (5 + 4 * k) + 1.2, 0.12)
    # The terminal at the left, its jet bridges, hangars at the right and beyond the runway.
    box("building", (-230, 96, 0), (-92, 250, 11))
    box("facade", (-229.5, 96.5, 11), (-94, 249, 15.5))
    box("building", (-235, 94, 15.5), (-89, 252, 16.6))
    for k in range(7):
        box("facade", (-92.3 + 0.5, 102 + 21 * k, 3.2), (-91.7, 119 + 21 * k, 9))
    for k in range(6):
        box("facade", (-226 + 22 * k, 95.6, 3.2), (-208 + 22 * k, 96.2, 9))
    for y in (118, 156):
        box("plane_white", (-92, y, 4), (-66, y + 3, 7))
        box("plane_grey", (-70, y - 0.6, 0), (-67, y + 3.6, 4))
    box("hangar", (135, 238, 0), (215, 292, 17))
    box("hangar_door", (142, 237.4, 0), (208, 238.2, 13))
    for k in range(6):
        box("hangar", (150 + 10.5 * k, 237.0, 0), (150.7 + 10.5 * k, 237.5, 13))
    box("building", (-120, 470, 0), (-30, 500, 9))
    box("hangar", (70, 476, 0), (150, 515, 15))
    box("hangar_door", (76, 475.4, 0), (144, 476.2, 11))
    box("building", (-420, 480, 0), (-250, 515, 13))
    for x, y in ((-66, 182), (30, 182), (118, 182), (-20, 228), (78, 228)):
        box("plane_grey", (x - 0.25, y - 0.25, 0), (x + 0.25, y + 0.25, 21))
        box("plane_grey", (x - 2.2, y - 0.5, 21), (x + 2.2, y + 0.5, 22.2))
    # Vehicles: trucks, tugs with carts, a stair.
    for x, y, w, d, h, name in (
        (-22, 108, 9, 2.6, 3.2, "truck_yellow"), (-12.4, 108, 2.2, 2.6, 2.4, "plane_white"), (33, 112, 7, 2.5, 3, "plane_white"),
        (40.3, 112, 2, 2.5, 2.4, "truck_yellow"), (76, 118, 8, 2.6, 3.4, "truck_red"), (84.3, 118, 2.2, 2.6, 2.5, "plane_white"),
        (-58, 140, 3, 1.8, 1.8, "truck_yellow"), (25, 148, 3, 1.8, 1.8, "truck_yellow"), (-5, 176, 4.5, 2, 1.7, "truck_yellow"),
    ):
        box(name, (x, y, 0.5), (x + w, y + d, 0.5 + h))
        box("plane_dark", (x + 0.3, y - 0.05, 0.1), (x + w - 0.3, y + d + 0.05, 0.8))
    for k in range(4):
        box("plane_grey", (-52 + 3.4 * k, 141, 0.4), (-49.4 + 3.4 * k, 142.7, 1.9))
        box("plane_grey", (30 + 3.4 * k, 149, 0.4), (32.6 + 3.4 * k, 150.7, 1.7))
    # Woods and hills: each farther one paler.
    rough = lambda x, seed: sin(x * 0.131 + seed) + 0.6 * sin(x * 0.317 + 2 * seed) + 0.4 * sin(x * 0.773 + 3 * seed) + 0.3 * sin(x * 1.7 + seed)
    ridge("wood", 600, 5, -1100, 1100, 4, lambda x: 9.5 + 1.6 * rough(x, 1.0))
    ridge("wood_far", 760, 10, -1200, 1200, 6, lambda x: 14 + 2.0 * rough(x * 0.7, 4.0) + 5 * sin(x / 170))
    ridge("hill_near", 1080, 180, -1500, 1500, 12, lambda x: 34 + 13 * sin(x / 210 + 0.5) + 7 * sin(x / 90) + 1.2 * rough(x * 0.4, 2.0))
    ridge("hill_far", 1400, 240, -1400, 1400, 15, lambda x: 78 + 26 * sin(x / 330 + 2.1) + 12 * sin(x / 140 + 1) + 1.5 * rough(x * 0.3, 5.0))


def main():
    cab()
    field()
    plane(-46, 138, 160, "tail_red", 1.3)
    plane(8, 133, 22, "tail_blue", 1.3)
    plane(68, 146, 204, "tail_orange", 1.3)
    plane(-22, 213, 180, "tail_green", 1.15)
    plane(120, 353, 180, "tail_red", 1.2)
    plane(-205, 353, 0, "tail_blue", 1.2)
    folder = Path(__file__).parent
    for name, faces in FACES.items():
        index, lines, polygons = {}, [], []
        for points in faces:
            corners = []
            for p in points:
                key = " ".join(f"{v:.4f}".rstrip("0").rstrip(".") for v in p).replace("-0 ", "0 ")
                if key not in index:
                    index[key] = len(index) + 1
                    lines.append("v " + key)
                if index[key] not in corners:
                    corners.append(index[key])
            if len(corners) >= 3:
                polygons.append("f " + " ".join(map(str, corners)))
        (folder / f"{name}.obj").write_text("\n".join(lines + polygons) + "\n")


main()
