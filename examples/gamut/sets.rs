//! The colours that the methods are tried on.

use luxpipe::Result;
use luxpipe::color::difference::lab_to_xyz;
use luxpipe::color::{Cat, Xy, adapt};
use luxpipe::filters::Pcond;
use luxpipe::spectral::{Observer, builtin};
use luxpipe::stream::{Block, Components, Header, Picture, Resolution, Units};

use super::methods::{pixels, through};

/// Colours with a name.
pub struct Set {
    pub title: &'static str,
    pub what: &'static str,
    pub colours: Vec<[f64; 3]>,
}

/// A picture in memory, its white D65.
pub struct Strip {
    header: Header,
    data: Vec<f32>,
    done: bool,
}

impl Strip {
    pub fn new(colours: &[[f64; 3]], columns: usize, units: Units) -> Strip {
        let rows = colours.len() / columns;
        let mut header = Header::new(Resolution::upright(columns, rows), Components::Xyz, 3, units);
        header.white = Some(Xy::D65);
        Strip { header, data: colours.iter().flatten().map(|x| *x as f32).collect(), done: false }
    }
}

impl Picture for Strip {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = !std::mem::replace(&mut self.done, true);
        block.data = if more { self.data.clone() } else { Vec::new() };
        block.rows = block.data.len() / self.header.scanline_floats();
        Ok(more)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.done = false;
        Ok(true)
    }
}

/// White of the display.
pub fn white() -> [f64; 3] {
    Xy::D65.xyz()
}

/// A wavelength mixed with a share of white, at luminance y.
pub fn mixed(nm: f64, share_of_white: f64, y: f64) -> [f64; 3] {
    let observer = Observer::cie1931().expect("built in");
    let pure = observer.cmf.each_ref().map(|c| c.at(nm));
    let w = white();
    [0, 1, 2].map(|i| y * (pure[i] / pure[1] * (1.0 - share_of_white) + w[i] * share_of_white))
}

pub fn locus() -> Set {
    let whites = [0.0, 0.25, 0.5, 0.75];
    let at = |nm: i32| whites.map(|w| mixed(f64::from(nm), w, 0.1));
    Set {
        title: "The spectral locus",
        what: "400 to 690 nm every 5 nm at a tenth of the white's luminance, 0, 25, 50 and 75 % of it white: 236 colours.",
        colours: (400..=690).step_by(5).flat_map(at).collect(),
    }
}

pub fn pointer() -> Set {
    let rows = include_str!("../../tests/ref/pointer_gamut.csv").lines().filter(|l| !l.starts_with(['#', 'L']));
    let c = Xy { x: 0.31005673, y: 0.3161457 };
    let to_d65 = adapt::von_kries(Cat::Bradford, c, Xy::D65, 1.0).expect("two whites");
    let colour = |line: &str| {
        let n: Vec<f64> = line.split(',').map(|n| n.parse().expect("a number")).collect();
        let h = n[2].to_radians();
        to_d65.apply(lab_to_xyz([n[0], n[1] * h.cos(), n[1] * h.sin()], c.xyz()))
    };
    Set {
        title: "Surface colours",
        what: "Pointer's boundary of real surface colours, L* 15 to 90 (tests/ref/pointer_gamut.csv), from C to D65 by Bradford: 576 \
               colours.",
        colours: rows.map(colour).collect(),
    }
}

/// Peaks in nm and luminances in cd/m2 of the lamps over each row of the picture.
const LAMPS: [&[(f64, f64)]; 5] =
    [&[], &[(450.0, 15.0)], &[(525.0, 60.0)], &[(630.0, 30.0)], &[(450.0, 15.0), (630.0, 30.0)]];

/// What a lamp sends at a wavelength: a Gaussian 20 nm wide at half its height.
fn lamp(peak_nm: f64, nm: f64) -> f64 {
    (-4.0 * 2f64.ln() * ((nm - peak_nm) / 20.0).powi(2)).exp()
}

pub fn picture() -> Set {
    let observer = Observer::cie1931().expect("built in");
    let d65 = builtin::spectrum("illuminant_D65").expect("built in");
    let grid = || (380..=780).map(f64::from);
    let cmf = |nm: f64| observer.cmf.each_ref().map(|c| c.at(nm));
    let with_luminance = |y: f64, power: Vec<f64>| -> Vec<f64> {
        let sum: f64 = grid().zip(&power).map(|(nm, p)| cmf(nm)[1] * p).sum();
        power.iter().map(|p| p * y / sum).collect()
    };
    let light = |lamps: &[(f64, f64)]| -> Vec<f64> {
        let day = with_luminance(if lamps.is_empty() { 100.0 } else { 1.0 }, grid().map(|nm| d65.at(nm)).collect());
        lamps.iter().fold(day, |sum, (peak, y)| {
            let more = with_luminance(*y, grid().map(|nm| lamp(*peak, nm)).collect());
            sum.iter().zip(more).map(|(a, b)| a + b).collect()
        })
    };
    let seen = |light: &[f64], name: &str| {
        let patch = builtin::spectrum(name).expect("built in");
        let add = |sum: [f64; 3], (nm, p): (f64, &f64)| [0, 1, 2].map(|i| sum[i] + cmf(nm)[i] * p * patch.at(nm));
        grid().zip(light).fold([0.0; 3], add)
    };
    let names: Vec<&str> = builtin::names().filter(|n| n.starts_with("cc_ohta_")).collect();
    let lights = LAMPS.map(light);
    let scene: Vec<[f64; 3]> = lights.iter().flat_map(|l| names.iter().map(|n| seen(l, n))).collect();
    let shown = through(Pcond::default(), Box::new(Strip::new(&scene, names.len(), Units::CdM2)));
    Set {
        title: "A picture",
        what: "A stage: the 24 patches of a chart (spectra/cc_ohta_*.csv) in daylight of 100 cd/m2, and under lamps 20 nm wide at \
               450, 525, 630 and 450 + 630 nm with 1 cd/m2 of daylight, summed at 1 nm, then `pcond`: 120 pixels. (The shipped \
               photograph, tests/data/radiance_office.hdr, has no component below 0 there.)",
        colours: pixels(shown),
    }
}
