"""Values of fl11_sweep.csv, bins_exact.csv, lasers.csv, cat_breakdowns.csv: numpy alone, nothing of luxpipe but spectra/.

    python3 tests/ref/colour.py        (numpy 2.4; the files it wrote are committed)
"""
import csv
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
SPECTRA = HERE.parent.parent / "spectra"
NM = np.arange(380, 781.0)


def table(name):
    rows = [line.split(",") for line in open(SPECTRA / f"{name}.csv") if line[0].isdigit()]
    return np.array(rows, float).T


def linear(name, at=NM):
    return np.interp(at, *table(name), left=0, right=0)


def sprague(name):
    """CIE 15: Sprague's fifth-order interpolation of a 5 nm table, to 1 nm."""
    x, y = table(name)
    ends = np.array([[884, -1960, 3033, -2648, 1080, -180], [508, -540, 488, -367, 144, -24]]) / 209
    r = np.concatenate([ends @ y[:6], y, (ends @ y[:-7:-1])[::-1]])
    i = np.minimum(((NM - x[0]) // 5).astype(int), len(x) - 2)
    t = (NM - x[0]) / 5 - i
    p = [r[i + k] for k in range(6)]
    rows = [[0, 0, 24, 0, 0, 0], [2, -16, 0, 16, -2, 0], [-1, 16, -30, 16, -1, 0], [-9, 39, -70, 66, -33, 7],
            [13, -64, 126, -124, 61, -12], [-5, 25, -50, 50, -25, 5]]
    return sum(sum(c * q for c, q in zip(row, p)) / 24 * t**k for k, row in enumerate(rows))


CMF = np.array([linear(f"cie1931_{c}") for c in "xyz"])
PATCHES = np.array([sprague(p.stem) for p in sorted(SPECTRA.glob("cc_ohta_*.csv"))])
LIGHTS = {n: (sprague if n == "C" or n[0] == "L" else linear)(f"illuminant_{n}")
          for n in ["A", "C", "D50", "D65", "FL2", "FL11", "LED-B3", "LED-RGB1"]}


def lab(xyz, white):
    t = xyz / white
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * 841 / 108 + 4 / 29)
    return np.array([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])])


def de2000(p, q):
    (l1, a1, b1), (l2, a2, b2) = p, q
    c = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    g = 1.5 - 0.5 * np.sqrt(c**7 / (c**7 + 25**7))
    c1, c2 = np.hypot(g * a1, b1), np.hypot(g * a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, g * a1)) % 360, np.degrees(np.arctan2(b2, g * a2)) % 360
    dh = (h2 - h1 + 180) % 360 - 180
    h = np.where(abs(h1 - h2) <= 180, (h1 + h2) / 2, (h1 + h2 + np.where(h1 + h2 < 360, 360, -360)) / 2)
    big_h, ll, cc = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(dh / 2)), (l1 + l2) / 2, (c1 + c2) / 2
    cos = lambda x: np.cos(np.radians(x))
    t = 1 - 0.17 * cos(h - 30) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6) - 0.2 * cos(4 * h - 63)
    turn = -2 * np.sqrt(cc**7 / (cc**7 + 25**7)) * np.sin(np.radians(60 * np.exp(-(((h - 275) / 25) ** 2))))
    dl = (l2 - l1) / (1 + 0.015 * (ll - 50) ** 2 / np.sqrt(20 + (ll - 50) ** 2))
    dc, dhh = (c2 - c1) / (1 + 0.045 * cc), big_h / (1 + 0.015 * cc * t)
    return np.sqrt(np.maximum(0, dl**2 + dc**2 + dhh**2 + turn * dc * dhh))


def errors(light, method):
    """dE 2000 of 24 patches: method(light) gives XYZ of the patches and of the white."""
    s = LIGHTS[light]
    white = CMF @ s
    truth = (PATCHES * s) @ CMF.T / white[1]
    xyz, own = method(s)
    return de2000(lab(truth, white / white[1]), lab(xyz / own[1], white / white[1]))


def points(nm):
    at = lambda f: np.interp(nm, NM, f)
    cmf, r = np.array([at(c) for c in CMF]), np.array([at(p) for p in PATCHES])
    return lambda s: ((r * at(s)) @ cmf.T, cmf @ at(s))


def integral(f, a, b):
    x = np.unique(np.concatenate([[a, b], NM[(NM > a) & (NM < b)]]))
    return np.trapezoid(np.interp(x, NM, f), x)


def bins(count, with_source):
    """Exact means and integrals of the piecewise linear 1 nm tables over equal bins of 380-780 nm."""
    edges = np.linspace(380, 780, count + 1)
    over = lambda f: np.array([integral(f, a, b) for a, b in zip(edges, edges[1:])])
    width, r = 400 / count, np.array([over(p) for p in PATCHES]) / (400 / count)

    def method(s):
        if with_source:
            w = np.array([over(c * s) for c in CMF])
            return r @ w.T, w.sum(1)
        w, sb = np.array([over(c) for c in CMF]), over(s) / width
        return (r * sb) @ w.T, w @ sb
    return method


def write(name, head, rows):
    with open(HERE / name, "w") as f:
        f.write("# made by tests/ref/colour.py from spectra/, numpy in double precision\n")
        out = csv.writer(f, lineterminator="\n")
        out.writerow(head)
        out.writerows([[f"{v:.6g}" if isinstance(v, float) else v for v in row] for row in rows])


def main():
    sweep = []
    for n in range(3, 41):
        mid = 380 + (np.arange(n) + 0.5) * 400 / n
        sweep.append([n] + [float(errors("FL11", m).max()) for m in (points(mid), bins(n, False), bins(n, True))])
    write("fl11_sweep.csv", ["n", "points", "bins", "bins_with_source"], sweep)

    rows = []
    for step in (5, 10, 20):
        for weighted in (False, True):
            all_ = {n: errors(n, bins(400 // step, weighted)) for n in LIGHTS}
            pooled = np.concatenate(list(all_.values()))
            smooth = max(all_[n].max() for n in ("A", "C", "D50", "D65"))
            rows.append([f"bins {step} nm" + (" source in weights" if weighted else "")] + [float(v) for v in (
                pooled.max(), pooled.mean(), smooth, *(all_[n].max() for n in ("FL2", "FL11", "LED-B3", "LED-RGB1")))])
    write("bins_exact.csv", "method,max_8,mean_8,smooth,FL2,FL11,LED-B3,LED-RGB1".split(","), rows)

    # A laser: 1 at 11 points of the 1 nm grid, falling to 0 within 1 nm. XYZ of a white diffuser, without 683.
    rows = []
    for centre in (450, 532, 640):
        s = (abs(NM - centre) <= 5) * 1.0
        x20 = np.arange(380, 781, 20.0)
        c20, s20 = np.array([np.interp(x20, NM, c) for c in CMF]), np.interp(x20, NM, s)
        edges = np.linspace(380, 780, 21)
        over = lambda f: np.array([integral(f, a, b) for a, b in zip(edges, edges[1:])])
        b20 = np.array([over(c) for c in CMF]) @ (over(s) / 20)
        rows.append([centre, *map(float, CMF @ s), *map(float, b20), *map(float, 20 * c20 @ s20)])
    write("lasers.csv", ["centre_nm"] + [m + c for m in ("true_", "bins20_", "points20_") for c in "XYZ"], rows)

    # The matrices as src/color/adapt.rs has them (cats.csv checks their values against another program's). Wavelengths
    # with a negative sensor response, and those whose luminance turns negative by full adaptation, as first-last:count.
    cats = {
        "cmccat2000": [[0.7982, 0.3389, -0.1371], [-0.5918, 1.5512, 0.0406], [0.0008, 0.0239, 0.9753]],
        "vonkries": [[0.38971, 0.68898, -0.07868], [-0.22981, 1.18340, 0.04641], [0, 0, 1]],
        "bradford": [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]],
        "sharp": [[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357], [0.0297, -0.0315, 1.0018]],
        "cat02": [[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]],
        "cat16": [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]],
    }
    xyz = lambda x, y: np.array([x / y, 1, (1 - x - y) / y])
    span = lambda bad: f"{NM[bad][0]:.0f}-{NM[bad][-1]:.0f}:{bad.sum()}" if bad.any() else "-"
    a, d65, rows = xyz(0.4475, 0.4075), xyz(0.3127, 0.3290), []
    for name, m in cats.items():
        m = np.array(m)
        to = lambda f, t: np.linalg.inv(m) @ np.diag((m @ t) / (m @ f)) @ m
        blue = to(a, d65) @ CMF[:, 450 - 380]
        rows.append([name, *(span(r < 0) for r in m @ CMF), span((to(a, d65) @ CMF)[1] < 0),
                     span((to(d65, a) @ CMF)[1] < 0), float(blue[1] / CMF[1, 450 - 380])])
    write("cat_breakdowns.csv", ["cat", "red<0", "green<0", "blue<0", "A_to_D65_Y<0", "D65_to_A_Y<0", "Y_gain_450_nm"],
          rows)


if __name__ == "__main__":
    main()
