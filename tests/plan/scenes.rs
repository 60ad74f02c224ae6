//! Random rooms for the planner: measured and synthetic spectra, one to three lamps, what stands in them.

use std::fmt::Write as _;

/// Numbers in 0..1 that are the same everywhere [Steele 2014].
pub struct Dice(u64);

impl Dice {
    /// Those of a scene.
    pub fn new(seed: u64) -> Dice {
        Dice(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ 0x6c62_272e_07bb_0142)
    }

    /// The next one.
    pub fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.roll()
    }

    /// One of some.
    pub fn one<'a, T: ?Sized>(&mut self, of: &[&'a T]) -> &'a T {
        of[(self.roll() * of.len() as f64) as usize]
    }

    fn point(&mut self, low: [f64; 3], high: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.within(low[i], high[i]))
    }
}

/// Which spectra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Paints under smooth lamps.
    Smooth,
    /// Paints under lamps with lines.
    Spiky,
    /// Any lamp; a third of the surfaces are edges or narrow bands.
    Steep,
}

/// All of them.
pub const CLASSES: [Class; 3] = [Class::Smooth, Class::Spiky, Class::Steep];

const SMOOTH: [&str; 6] = ["A", "D50", "D65", "LED-B1", "LED-B3", "LED-B5"];
const SPIKY: [&str; 6] = ["FL2", "FL7", "FL11", "FL12", "LED-RGB1", "lasers"];
const PAINTS: [&str; 24] = [
    "01_dark_skin",
    "02_light_skin",
    "03_blue_sky",
    "04_foliage",
    "05_blue_flower",
    "06_bluish_green",
    "07_orange",
    "08_purplish_blue",
    "09_moderate_red",
    "10_purple",
    "11_yellow_green",
    "12_orange_yellow",
    "13_blue",
    "14_green",
    "15_red",
    "16_yellow",
    "17_magenta",
    "18_cyan",
    "19_white_9_5",
    "20_neutral_8",
    "21_neutral_6_5",
    "22_neutral_5",
    "23_neutral_3_5",
    "24_black_2",
];

/// A spectrum as a table of points every 2 nm.
fn table(f: impl Fn(f64) -> f64) -> String {
    let points: Vec<String> =
        (0..=210).map(|i| 370.0 + 2.0 * f64::from(i)).map(|nm| format!("[{nm},{:.6}]", f(nm))).collect();
    format!("[{}]", points.join(","))
}

/// A reflectance as the scene file has it.
pub fn reflectance(dice: &mut Dice, class: Class) -> String {
    if class != Class::Steep || dice.roll() > 1.0 / 3.0 {
        return format!("\"cc_{}_{}\"", dice.one(&["ohta", "babel"]), dice.one(&PAINTS));
    }
    let (at, low, high) = (dice.within(420.0, 700.0), dice.within(0.02, 0.2), dice.within(0.5, 0.95));
    let width = dice.within(5.0, 20.0);
    let edge = |nm: f64, at: f64| 1.0 / (1.0 + (-(nm - at) * 4.0 / width).exp());
    if dice.roll() < 0.5 {
        let rising = dice.roll() < 0.7;
        table(|nm| low + (high - low) * if rising { edge(nm, at) } else { 1.0 - edge(nm, at) })
    } else {
        let band = dice.within(15.0, 40.0);
        let notch = dice.roll() < 0.3;
        let pass = |nm: f64| edge(nm, at - 0.5 * band) * (1.0 - edge(nm, at + 0.5 * band));
        table(|nm| low + (high - low) * if notch { 1.0 - pass(nm) } else { pass(nm) })
    }
}

/// A lamp's spectrum as the scene file has it.
pub fn lamp(dice: &mut Dice, class: Class) -> String {
    let spiky = class == Class::Spiky || class == Class::Steep && dice.roll() < 0.5;
    match dice.one(if spiky { &SPIKY } else { &SMOOTH }) {
        "lasers" => table(|nm| {
            let line = |at: f64| (-0.5 * ((nm - at) / 4.25).powi(2)).exp();
            line(450.0) + 1.1 * line(532.0) + 1.5 * line(635.0)
        }),
        name => format!("\"{name}\""),
    }
}

/// A room of 4 x 3 x 4 m, seen from a corner.
pub fn room(seed: u64, class: Class) -> String {
    let mut dice = Dice::new(seed);
    let mut text = String::from(
        "[camera]\ntype = \"perspective\"\norigin = [0.3, 0.3, 1.6]\ntarget = [2.8, 2.8, 1.1]\nup = [0, 0, 1]\nfov_deg = 75\nwidth = 24\nheight = 18\n",
    );
    let _ = writeln!(text, "[materials.lamp]\nreflectance = 0");
    let count = 5 + (10.0 * dice.roll()) as usize;
    for i in 0..count {
        let own = reflectance(&mut dice, class);
        let kind = match (10.0 * dice.roll()) as u32 {
            0 => format!("type = \"coated\"\nreflectance = {own}\nroughness = {:.2}", dice.roll() * 0.5),
            1 => format!(
                "type = \"conductor\"\nmetal = \"{}\"\nroughness = {:.2}",
                dice.one(&["Ag", "Al", "Au", "Cu"]),
                dice.within(0.1, 0.6)
            ),
            2 => format!("type = \"plastic\"\nreflectance = {own}\nspecular = 0.05\nroughness = 0.1"),
            3 => format!("type = \"mirror\"\nreflectance = {own}"),
            _ => format!("reflectance = {own}"),
        };
        let _ = writeln!(text, "[materials.m{i}]\n{kind}");
    }
    let lamps = 1 + (3.0 * dice.roll()) as usize;
    for i in 0..lamps {
        let (spectrum, luminance) = (lamp(&mut dice, class), 1000.0 * 10f64.powf(dice.roll()));
        let _ = writeln!(text, "[lights.l{i}]\nspectrum = {spectrum}\nluminance = {luminance:.1}");
    }
    let mut quad = |points: [[f64; 3]; 4], material: &str, light: Option<usize>| {
        let points: Vec<String> = points.iter().map(|p| format!("{p:?}")).collect();
        let light = light.map_or(String::new(), |l| format!("light = \"l{l}\"\n"));
        let _ = writeln!(
            text,
            "[[shape]]\ntype = \"quad\"\npoints = [{}]\nmaterial = \"{material}\"\n{light}",
            points.join(", ")
        );
    };
    let (x, y, z) = (4.0, 4.0, 3.0);
    let walls = [
        [[0.0, 0.0, 0.0], [x, 0.0, 0.0], [x, y, 0.0], [0.0, y, 0.0]],
        [[0.0, 0.0, z], [0.0, y, z], [x, y, z], [x, 0.0, z]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, z], [x, 0.0, z], [x, 0.0, 0.0]],
        [[0.0, y, 0.0], [x, y, 0.0], [x, y, z], [0.0, y, z]],
        [[0.0, 0.0, 0.0], [0.0, y, 0.0], [0.0, y, z], [0.0, 0.0, z]],
        [[x, 0.0, 0.0], [x, 0.0, z], [x, y, z], [x, y, 0.0]],
    ];
    let of = |dice: &mut Dice| format!("m{}", (dice.roll() * count as f64) as usize);
    for wall in walls {
        let material = of(&mut dice);
        quad(wall, &material, None);
    }
    for i in 0..lamps {
        let [a, b, _] = dice.point([0.3, 0.3, 0.0], [3.0, 3.0, 0.0]);
        let (c, d, h) = (a + dice.within(0.2, 0.6), b + dice.within(0.2, 0.6), z - 0.01);
        quad([[a, b, h], [a, d, h], [c, d, h], [c, b, h]], "lamp", Some(i));
    }
    let things = 3 + (4.0 * dice.roll()) as usize;
    for _ in 0..things {
        let material = of(&mut dice);
        if dice.roll() < 0.5 {
            let (center, radius) = (dice.point([1.2, 1.2, 0.3], [3.5, 3.5, 1.5]), dice.within(0.15, 0.4));
            let _ = writeln!(
                text,
                "[[shape]]\ntype = \"sphere\"\ncenter = {center:?}\nradius = {radius:.3}\nmaterial = \"{material}\""
            );
        } else {
            let low = dice.point([1.2, 1.2, 0.0], [3.2, 3.2, 0.6]);
            let high = [low[0] + dice.within(0.2, 0.6), low[1] + dice.within(0.2, 0.6), low[2] + dice.within(0.3, 1.0)];
            let _ =
                writeln!(text, "[[shape]]\ntype = \"box\"\nmin = {low:?}\nmax = {high:?}\nmaterial = \"{material}\"");
        }
    }
    text
}
