#!/usr/bin/env python3
"""Write the spectral tables of this folder from public packages.

    pip install colour-science==0.4.7 PyYAML
    pip install --no-deps luxpy==1.12.5 pyElli==0.23.1
    python3 spectra/generate.py

luxpy and pyElli are only read as data files (never imported), so their own
dependencies are not needed. The result depends on the three pinned versions
alone: a second run writes the same bytes.

Every file is `# ` comments (what, unit, source, licence), the header line
`wavelength_nm,value`, and rows in ascending wavelength with all the digits of
the source. The four cornell_*.csv files are primary tables that no package
carries; they are checked here, not written.
"""

import importlib.metadata
import importlib.util
import math
import re
import warnings
from decimal import Decimal
from pathlib import Path

import yaml

warnings.simplefilter("ignore")  # colour-science mentions its optional plotting parts
import colour  # noqa: E402

HERE = Path(__file__).resolve().parent
PINNED = {"colour-science": "0.4.7", "luxpy": "1.12.5", "pyElli": "0.23.1"}

CIE_LICENCE = "CIE publishes its data tables under CC BY-SA 4.0; colour-science is BSD-3-Clause"
COLOUR = "colour-science 0.4.7"
DATABASE = "refractiveindex.info database 2025.02.23, as packed in pyElli 0.23.1"
PUBLIC_DOMAIN = "refractiveindex.info database: CC0 1.0 (public domain)"


# Writing and reading

def shortest(number):
    """The shortest decimal that reads back as the same double, without a trailing `.0`."""
    text = repr(float(number))
    return text[:-2] if text.endswith(".0") else text


def write(name, what, unit, source, licence, rows):
    """Write one table; refuse one that is not finite or not ascending."""
    rows = [(float(wavelength), float(value)) for wavelength, value in rows]
    wavelengths = [wavelength for wavelength, _ in rows]
    assert all(a < b for a, b in zip(wavelengths, wavelengths[1:])), f"{name}: not ascending"
    assert all(math.isfinite(value) for _, value in rows), f"{name}: not finite"
    lines = [f"# {what}", f"# unit: {unit}", f"# source: {source}", f"# licence: {licence}",
             "wavelength_nm,value"]
    lines += [f"{shortest(wavelength)},{shortest(value)}" for wavelength, value in rows]
    (HERE / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def read(name):
    """The rows of one table of this folder."""
    text = (HERE / f"{name}.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    assert lines[0] == "wavelength_nm,value", f"{name}: header"
    return [tuple(map(float, line.split(","))) for line in lines[1:]]


def data_of(package, *parts):
    """A data file inside an installed package, found without importing the package."""
    folder = importlib.util.find_spec(package).submodule_search_locations[0]
    return Path(folder).joinpath(*parts)


def rows_of(distribution):
    return zip(distribution.wavelengths, distribution.values)


def snake(name):
    """`white 9.5 (.05 D)` -> `white_9_5`."""
    return re.sub(r"[^a-z0-9]+", "_", re.sub(r"\(.*\)", "", name.lower())).strip("_")


# Observers

OBSERVERS = [
    # file, name in colour-science, publication
    ("cie1931", "CIE 1931 2 Degree Standard Observer",
     "ISO/CIE 11664-1:2019 (CIE data table DOI 10.25039/CIE.DS.xvudnb9b)"),
    ("cie1964", "CIE 1964 10 Degree Standard Observer",
     "ISO/CIE 11664-1:2019 (CIE data table DOI 10.25039/CIE.DS.sqksu2n5)"),
    ("cie2015_2deg", "CIE 2015 2 Degree Standard Observer", "CIE 170-2:2015, by way of CVRL"),
    ("cie2015_10deg", "CIE 2015 10 Degree Standard Observer", "CIE 170-2:2015, by way of CVRL"),
]


def observers():
    for file, name, publication in OBSERVERS:
        functions = colour.MSDS_CMFS[name]
        for axis, values in zip("xyz", functions.values.T):
            write(f"{file}_{axis}", f"{name}, colour-matching function {axis}-bar",
                  "relative (1 at the peak of y-bar)", f"{publication}; {COLOUR}", CIE_LICENCE,
                  zip(functions.wavelengths, values))


EFFICIENCIES = [
    ("photopic_v", "CIE 1924 Photopic Standard Observer", "V(lambda), photopic vision",
     "CIE 018:2019 (CIE data table DOI 10.25039/CIE.DS.dktna2s3)"),
    ("scotopic_v", "CIE 1951 Scotopic Standard Observer", "V'(lambda), scotopic vision",
     "CIE 018:2019 (CIE data table DOI 10.25039/CIE.DS.gr6w4b5g)"),
]


def luminous_efficiencies():
    for file, name, what, publication in EFFICIENCIES:
        write(file, f"CIE spectral luminous efficiency {what}", "relative (1 at the peak)",
              f"{publication}; {COLOUR}", CIE_LICENCE, rows_of(colour.SDS_LEFS[name]))


ALPHA_OPIC = ["s_cone", "m_cone", "l_cone", "rhodopic", "melanopic"]  # the table's columns


def alpha_opic_spectra():
    """CIE S 026 leaves the cones blank where it defines no value: those rows are absent here."""
    table = data_of("luxpy", "toolboxes", "photbiochem", "data",
                    "S026_Table2_Data_downloaded_04062025.csv")
    cells = [line.split(",") for line in table.read_text(encoding="utf-8-sig").splitlines()[1:]]
    for column, name in enumerate(ALPHA_OPIC, start=1):
        write(f"alphaopic_{name}", f"CIE S 026 alpha-opic action spectrum, {name.replace('_', ' ')}",
              "relative, energy (1 at the peak)",
              "CIE S 026/E:2018 Table 2 (CIE data table DOI 10.25039/CIE.DS.vqqhzp5a);"
              " luxpy 1.12.5, S026_Table2_Data_downloaded_04062025.csv",
              "CIE publishes its data tables under CC BY-SA 4.0",
              [(row[0], row[column]) for row in cells if row[column].strip()])


# Illuminants

RELATIVE_POWER = "relative spectral power"


def illuminant_a():
    """Planck's law as CIE 15 writes it; in decimals, so that no maths library shows."""
    def radiator(wavelength):
        wavelength = Decimal(wavelength)
        exponent = Decimal("1.435e7") / (2848 * wavelength)
        return 1 / (wavelength ** 5 * (exponent.exp() - 1))

    write("illuminant_A", "CIE standard illuminant A", f"{RELATIVE_POWER}, 100 at 560 nm",
          "the defining formula of CIE 15 and ISO/CIE 11664-2:"
          " 100 (560/l)^5 (exp(1.435e7/(2848*560)) - 1) / (exp(1.435e7/(2848 l)) - 1)",
          "a formula",
          [(l, 100 * radiator(l) / radiator(560)) for l in range(300, 831)])


def illuminant_e():
    write("illuminant_E", "CIE illuminant E (equal energy)", f"{RELATIVE_POWER}, 100 everywhere",
          "CIE 15, by definition", "a definition", [(l, 100) for l in range(300, 831, 5)])


TABULATED = (["B", "C", "D50", "D55", "D65", "D75"] + [f"FL{i}" for i in range(1, 13)]
             + [f"LED-B{i}" for i in range(1, 6)] + ["LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"])


def tabulated_illuminants():
    for name in TABULATED:
        unit = f"{RELATIVE_POWER}, 100 at 560 nm" if name[0] == "D" else RELATIVE_POWER
        publication = "CIE 15:2004" if name[0] in "BC" else "CIE 015:2018"
        write(f"illuminant_{name}", f"CIE illuminant {name}", unit, f"{publication}; {COLOUR}",
              CIE_LICENCE, rows_of(colour.SDS_ILLUMINANTS[name]))


def daylight_basis():
    for name in ["S0", "S1", "S2"]:
        write(f"daylight_{name}", f"CIE daylight component {name}(lambda)", RELATIVE_POWER,
              f"CIE 15:2004 Table T.2; {COLOUR}", CIE_LICENCE,
              rows_of(colour.colorimetry.SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES[name]))


# Reflectances

COLORCHECKERS = [
    ("cc_ohta", "ColorChecker N Ohta", "one chart measured by N. Ohta, 1997",
     "N. Ohta, The Basis of Color Reproduction Engineering (1997), by way of the Munsell Color"
     " Science Laboratory",
     "published as educational data, no licence stated; colour-science is BSD-3-Clause"),
    ("cc_babel", "BabelColor Average", "average of 30 charts, BabelColor, 2012",
     "D. Pascale, ColorChecker RGB and spectra (BabelColor, 2012)",
     "(C) 2004-2012 Danny Pascale (www.babelcolor.com), used by permission in colour-science"),
]


def colorcheckers():
    for file, name, measured, publication, licence in COLORCHECKERS:
        for number, (patch, reflectance) in enumerate(colour.SDS_COLOURCHECKERS[name].items(), 1):
            write(f"{file}_{number:02}_{snake(patch)}",
                  f"ColorChecker patch {number}, {patch}: {measured}", "reflectance, 0 to 1",
                  f"{publication}; {COLOUR}", licence, rows_of(reflectance))


def srgb_basis():
    basis = colour.recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    for name, values in zip(basis.labels, basis.values.T):
        write(f"srgb_basis_{name}", f"reflectance of the sRGB primary {name}; the three sum to 1", "reflectance, 0 to 1",
              "I. Mallett and C. Yuksel, Spectral Primary Decomposition for Rendering with sRGB Reflectance, EGSR 2019"
              f" (supplemental data); {COLOUR}", "published with the paper, no licence stated; colour-science is BSD-3-Clause",
              zip(basis.wavelengths, values))


CORNELL = {name: list(range(400, 701, 4)) for name in ["white", "green", "red"]}
CORNELL["light"] = [400, 500, 600, 700]


def verify_cornell_box():
    for name, wavelengths in CORNELL.items():
        rows = read(f"cornell_{name}")
        top = 18.4 if name == "light" else 1
        assert [wavelength for wavelength, _ in rows] == wavelengths, f"cornell_{name}: wavelengths"
        assert all(0 <= value <= top for _, value in rows), f"cornell_{name}: values"


# Refractive indices

def material(path):
    """One record of the refractiveindex.info database."""
    file = data_of("elli", "database", "refractiveindexinfo-database", "database", "data", path)
    return yaml.safe_load(file.read_text(encoding="utf-8"))["DATA"][0]


def tabulated_index(path, low, high):
    """Rows (nm, n, k) from the last at or below `low` to the first at or above `high`."""
    words = [line.split() for line in material(path)["data"].splitlines()]
    rows = [(Decimal(l) * 1000, float(n), float(k)) for l, n, k in words]
    first = max(i for i, row in enumerate(rows) if i == 0 or row[0] <= low)
    last = min(i for i, row in enumerate(rows) if i == len(rows) - 1 or row[0] >= high)
    return rows[first:last + 1]


def sellmeier(path):
    """n as a function of the wavelength in nm, from the database's formula 1 or 2."""
    record = material(path)
    constant, *terms = map(float, record["coefficients"].split())
    squared = record["type"] == "formula 1"  # formula 2 lists the resonances squared already

    def index(wavelength):
        square = (wavelength / 1000) * (wavelength / 1000)
        total = 1 + constant
        for strength, resonance in zip(terms[::2], terms[1::2]):
            total += strength * square / (square - (resonance * resonance if squared else resonance))
        return math.sqrt(total)

    return index


JOHNSON = "P. B. Johnson and R. W. Christy, Phys. Rev. B 6, 4370-4379 (1972)"
RAKIC = "A. D. Rakic, Appl. Opt. 34, 4755-4767 (1995)"
METALS = [
    ("Au", "gold", JOHNSON, "main/Au/nk/Johnson.yml"),
    ("Ag", "silver", JOHNSON, "main/Ag/nk/Johnson.yml"),
    ("Cu", "copper", JOHNSON, "main/Cu/nk/Johnson.yml"),
    ("Al", "aluminium", RAKIC, "main/Al/nk/Rakic.yml"),
]


def metals():
    for symbol, metal, publication, path in METALS:
        rows = tabulated_index(path, 200, 2600)
        for part, what, column in [("n", "refractive index", 1), ("k", "extinction coefficient", 2)]:
            write(f"{symbol}_{part}", f"{metal} ({symbol}), {what} {part} of n + ik", "1",
                  f"{publication}; {DATABASE}, {path}", PUBLIC_DOMAIN,
                  [(row[0], row[column]) for row in rows])


SCHOTT = "SCHOTT Zemax catalog 2017-01-20b (data sheet Sellmeier coefficients)"
DIELECTRICS = [
    # file, what, publication, record, first and last nm
    ("glass_BK7", "borosilicate crown glass SCHOTT N-BK7, 20 C, relative to air",
     SCHOTT, "specs/schott/optical/N-BK7.yml", 300, 2500),
    ("glass_SF10", "dense flint glass SCHOTT SF10, 20 C, relative to air"
     " (extrapolated below the data sheet's 380 nm, where it absorbs)",
     SCHOTT, "specs/schott/optical/SF10.yml", 300, 2500),
    ("glass_F2", "flint glass SCHOTT F2, 20 C, relative to air"
     " (extrapolated below the data sheet's 320 nm, where it absorbs)",
     SCHOTT, "specs/schott/optical/F2.yml", 300, 2500),
    ("glass_fused_silica", "fused silica, 20 C",
     "I. H. Malitson, J. Opt. Soc. Am. 55, 1205-1208 (1965)", "main/SiO2/nk/Malitson.yml", 300, 2500),
    ("water", "distilled water, 20 C (the fit holds to 1129 nm; water_hale_n goes further)",
     "M. Daimon and A. Masumura, Appl. Opt. 46, 3811-3820 (2007)",
     "main/H2O/nk/Daimon-20.0C.yml", 200, 1120),
]


def dielectrics():
    for file, what, publication, path, first, last in DIELECTRICS:
        index = sellmeier(path)
        write(f"{file}_n", f"{what}: refractive index n", "1",
              f"{publication}, evaluated every 10 nm; {DATABASE}, {path}", PUBLIC_DOMAIN,
              [(l, index(l)) for l in range(first, last + 1, 10)])
    path = "main/H2O/nk/Hale.yml"
    write("water_hale_n", "water, 25 C: refractive index n (three decimals, to the infrared)", "1",
          f"G. M. Hale and M. R. Querry, Appl. Opt. 12, 555-563 (1973); {DATABASE}, {path}",
          PUBLIC_DOMAIN, [row[:2] for row in tabulated_index(path, 200, 2600)])


def main():
    for package, version in PINNED.items():
        found = importlib.metadata.version(package)
        if found != version:
            raise SystemExit(f"{package} is {found}; these tables come from {version}")
    observers()
    luminous_efficiencies()
    alpha_opic_spectra()
    illuminant_a()
    illuminant_e()
    tabulated_illuminants()
    daylight_basis()
    colorcheckers()
    srgb_basis()
    metals()
    dielectrics()
    verify_cornell_box()


if __name__ == "__main__":
    main()
