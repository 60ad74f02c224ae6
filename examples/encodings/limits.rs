//! What each encoding makes of what it cannot hold: pictures of two pixels, through the filters.

use luxpipe::color::Xy;
use luxpipe::color::difference::delta_e_2000;
use luxpipe::spectral::Observer;
use luxpipe::stream::{Components, Header, Resolution, Units};

use super::coders::ENCODINGS;
use super::files::{Memory, folder, read_xyz, record};

/// Two pixels, the first a grey of 1 cd/m2, and what came back.
struct Probe {
    seen: [[f64; 3]; 2],
    remarks: Vec<String>,
}

fn probe(command: &str, xyz: [f64; 3]) -> Probe {
    let mut header = Header::new(Resolution::upright(2, 1), Components::Xyz, 3, Units::CdM2);
    header.white = Some(Xy::D65);
    let pixels = [Xy::D65.xyz(), xyz].concat().iter().map(|x| *x as f32).collect();
    let dir = folder();
    let path = dir.path().join("out");
    let remarks = record(command, Memory::new(header, pixels), &path).expect("two pixels that fit");
    let seen = read_xyz(&path).expect("two pixels");
    Probe { seen: [0, 1].map(|p| [0, 1, 2].map(|i| f64::from(seen[3 * p + i]))), remarks }
}

/// A wavelength at 1 cd/m2.
fn monochromatic(nm: f64) -> [f64; 3] {
    let observer = Observer::cie1931().expect("built in");
    let [x, y, z] = observer.cmf.each_ref().map(|c| c.at(nm));
    [x / y, 1.0, z / y]
}

fn number(x: f64) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.1e}") }
}

/// The luminance that came back, and what it made of the pixel beside it where that changed.
fn luminance(probe: &Probe) -> String {
    let beside = probe.seen[0][1];
    let own = number(probe.seen[1][1]);
    if (beside - 1.0).abs() < 0.02 { own } else { format!("{own}; the 1: {}", number(beside)) }
}

/// A row of the table, and what the filter said.
fn row(command: &str) -> (String, Vec<String>) {
    let white = Xy::D65.xyz();
    let wanted = monochromatic(520.0);
    let green = probe(command, wanted);
    let exposed = |c: [f64; 3]| c.map(|x| 0.184_187 * x); // L* = 50
    let delta_e = delta_e_2000(exposed(wanted), exposed(green.seen[1]), white);
    let greys = [1e-6, 1e6, 1e25, f64::NAN].map(|y| probe(command, white.map(|x| x * y)));
    let cells: Vec<String> = greys.iter().map(luminance).collect();
    let text = format!("| `{command}` | {:.2} | {delta_e:.2} | {} |\n", green.seen[1][1], cells.join(" | "));
    let remarks = [&green, &greys[0], &greys[1]].into_iter().flat_map(|p| p.remarks.clone()).collect();
    (text, remarks)
}

/// The section of the page.
pub fn page() -> String {
    let mut commands: Vec<&str> = ENCODINGS.iter().map(|e| e.command).collect();
    commands.insert(1, "ra_rgbe --gamut desaturate");
    let (rows, remarks): (Vec<String>, Vec<Vec<String>>) = commands.iter().map(|c| row(c)).unzip();
    let said = commands.iter().zip(&remarks).filter(|(_, r)| !r.is_empty());
    let lines: String = said.map(|(c, r)| format!("- `{c}`: {}\n", r.join("; "))).collect();
    format!("{HEAD}{}\n{SAYS}{lines}", rows.concat())
}

const HEAD: &str = "\
## What becomes of the rest

Pictures of two pixels, a grey of 1 cd/m2 and the one named, through the filters: light of 520 nm at 1 cd/m2, and what comes back \
as luminance and as Delta E 2000; greys far below and above, in cd/m2, and NaN. A changed grey beside them is told.

| command | 520 nm: cd/m2 | Delta E | 1e-6 | 1e6 | 1e25 | `NaN` |
|---|---|---|---|---|---|---|
";

const SAYS: &str = "\
What the filters say of 520 nm, 1e-6 and 1e6 (`--gamut desaturate` was asked for, and says nothing):

";
