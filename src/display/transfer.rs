//! Transfer functions: display light to code values and back.

use crate::simd::bound;

/// How a display turns codes into light. Light is a share of the range from black to white, 0..1; codes are 0..1 too.
#[derive(Clone, Debug, PartialEq)]
pub enum Transfer {
    /// IEC 61966-2-1.
    Srgb,
    /// A plain power.
    Gamma(f64),
    /// SMPTE ST 2084: absolute luminance, 10,000 cd/m2 at code 1.
    Pq,
    /// ITU-R BT.2100 hybrid log-gamma, with the system gamma of the display's peak.
    Hlg,
    /// Light at evenly spaced codes from 0 to 1, rising.
    Table(Vec<f64>),
}

/// The sRGB curve.
///
/// ```
/// assert!((luxpipe::display::transfer::srgb_encode(0.214_041_14) - 0.5).abs() < 1e-7);
/// ```
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Back from the sRGB curve.
pub fn srgb_decode(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

const PQ_M1: f64 = 2610.0 / 16384.0;
const PQ_M2: f64 = 2523.0 / 32.0;
const PQ_C1: f64 = 3424.0 / 4096.0;
const PQ_C2: f64 = 2413.0 / 128.0;
const PQ_C3: f64 = 2392.0 / 128.0;
/// Luminance of PQ code 1, cd/m2.
pub const PQ_PEAK_CD_M2: f64 = 10_000.0;

/// ST 2084 code of a luminance.
///
/// ```
/// assert!((luxpipe::display::transfer::pq_encode(100.0) - 0.508_078).abs() < 1e-6);
/// ```
pub fn pq_encode(luminance_cd_m2: f64) -> f64 {
    let y = (luminance_cd_m2 / PQ_PEAK_CD_M2).max(0.0).powf(PQ_M1);
    ((PQ_C1 + PQ_C2 * y) / (1.0 + PQ_C3 * y)).powf(PQ_M2)
}

/// Luminance of an ST 2084 code.
pub fn pq_decode(code: f64) -> f64 {
    let n = code.max(0.0).powf(1.0 / PQ_M2);
    PQ_PEAK_CD_M2 * ((n - PQ_C1).max(0.0) / (PQ_C2 - PQ_C3 * n)).powf(1.0 / PQ_M1)
}

/// BT.2100 HLG code of scene light 0..1.
///
/// ```
/// assert!((luxpipe::display::transfer::hlg_encode(1.0 / 12.0) - 0.5).abs() < 1e-12);
/// ```
pub fn hlg_encode(scene: f64) -> f64 {
    const A: f64 = 0.178_832_77;
    let (b, c) = (1.0 - 4.0 * A, 0.5 - A * (4.0 * A).ln());
    if scene <= 1.0 / 12.0 { (3.0 * scene).sqrt() } else { A * (12.0 * scene - b).ln() + c }
}

/// Scene light of a BT.2100 HLG code.
pub fn hlg_decode(code: f64) -> f64 {
    const A: f64 = 0.178_832_77;
    let (b, c) = (1.0 - 4.0 * A, 0.5 - A * (4.0 * A).ln());
    if code <= 0.5 { code * code / 3.0 } else { (((code - c) / A).exp() + b) / 12.0 }
}

impl Transfer {
    /// Back from [`Transfer::encode`]: the light, as shares 0..1 of the range from `black` to `white`, of codes 0..1.
    pub fn light(&self, codes: [f64; 3], (black, white): (f64, f64), y: [f64; 3]) -> [f64; 3] {
        match self {
            Transfer::Pq => codes.map(|c| ((pq_decode(c) - black) / (white - black)).clamp(0.0, 1.0)),
            Transfer::Hlg => Transfer::hlg_display(codes.map(hlg_decode), white, y),
            _ => self.shares(codes),
        }
    }

    /// What an HLG display of that white, cd/m2, makes of scene light; `y` is the luminance row.
    pub fn hlg_display(scene: [f64; 3], white: f64, y: [f64; 3]) -> [f64; 3] {
        let gamma = 1.2 + 0.42 * (white / 1000.0).log10();
        let luminance: f64 = scene.iter().zip(y).map(|(a, b)| a * b).sum();
        scene.map(|x| if luminance > 0.0 { x * luminance.powf(gamma - 1.0) } else { 0.0 })
    }

    /// The same for curves that treat each channel alone; codes of the others are taken for light.
    pub(super) fn shares(&self, codes: [f64; 3]) -> [f64; 3] {
        codes.map(|c| self.decode(c).unwrap_or(c))
    }

    /// Codes 0..1 of linear RGB shares 0..1 on a display from `black` to `white` cd/m2; `y` is the luminance row.
    pub fn encode(&self, rgb: [f64; 3], (black, white): (f64, f64), y: [f64; 3]) -> [f64; 3] {
        match self {
            Transfer::Srgb => rgb.map(srgb_encode),
            Transfer::Gamma(g) => rgb.map(|x| x.powf(1.0 / g)),
            Transfer::Pq => rgb.map(|x| pq_encode(black + x * (white - black))),
            Transfer::Hlg => {
                // The display's own OOTF is undone first: light = scene x scene luminance ^ (gamma - 1).
                let gamma = 1.2 + 0.42 * (white / 1000.0).log10();
                let luminance: f64 = rgb.iter().zip(y).map(|(a, b)| a * b).sum();
                let gain = if luminance > 0.0 { luminance.powf(1.0 / gamma - 1.0) } else { 0.0 };
                rgb.map(|x| hlg_encode((x * gain).min(1.0)))
            }
            Transfer::Table(light) => rgb.map(|x| {
                let above = light.partition_point(|l| *l < x).clamp(1, light.len() - 1);
                let (a, b) = (light[above - 1], light[above]);
                let part = if b > a { (x - a) / (b - a) } else { 0.0 };
                (above as f64 - 1.0 + part) / (light.len() - 1) as f64
            }),
        }
    }

    /// Light share of a code, for curves that treat each channel alone and know no absolute luminance.
    fn decode(&self, code: f64) -> Option<f64> {
        match self {
            Transfer::Srgb => Some(srgb_decode(code)),
            Transfer::Gamma(g) => Some(code.powf(*g)),
            Transfer::Table(light) => {
                let at = code * (light.len() - 1) as f64;
                let below = (at as usize).min(light.len() - 2);
                Some(light[below] + (light[below + 1] - light[below]) * (at - below as f64))
            }
            Transfer::Pq | Transfer::Hlg => None,
        }
    }

    /// Transfer characteristics of ITU-T H.273, for a cICP chunk.
    pub fn cicp(&self) -> Option<u8> {
        match self {
            Transfer::Srgb => Some(13),
            Transfer::Pq => Some(16),
            Transfer::Hlg => Some(18),
            Transfer::Gamma(_) | Transfer::Table(_) => None,
        }
    }
}

/// Linear light to the nearest code of 8 bits: the leading bits of the float give a first guess, thresholds between
/// codes the answer, so that no power is computed a pixel.
pub struct Coder8 {
    /// Light from which code i holds, i = 0..255; then infinity.
    thresholds: [f32; 257],
    guess: Vec<u8>,
}

/// Bits of the float that index the guess: exponent and six of mantissa.
const SHIFT: u32 = 23 - 6;

impl Coder8 {
    /// For a curve that treats each channel alone; `None` for PQ and HLG.
    pub fn new(transfer: &Transfer) -> Option<Coder8> {
        let mut thresholds = [f32::INFINITY; 257];
        thresholds[0] = f32::NEG_INFINITY;
        for (code, t) in thresholds.iter_mut().enumerate().take(256).skip(1) {
            *t = transfer.decode((code as f64 - 0.5) / 255.0)? as f32;
        }
        let last = 1.0f32.to_bits() >> SHIFT;
        let guess = (0..=last).map(|i| {
            let x = f32::from_bits(i << SHIFT);
            (thresholds[1..256].partition_point(|t| *t <= x)) as u8
        });
        Some(Coder8 { thresholds, guess: guess.collect() })
    }

    /// The code nearest to the display value of `linear`; 0 for NaN and below, 255 above 1.
    #[inline]
    pub fn code(&self, linear: f32) -> u8 {
        let x = bound(linear, 0.0, 1.0);
        let mut code = usize::from(self.guess[(x.to_bits() >> SHIFT) as usize]);
        while x >= self.thresholds[code + 1] {
            code += 1;
        }
        code as u8
    }
}

/// Linear light to the nearest code of 16 bits, for curves that treat each channel alone: a line between neighbours of
/// a small table gives a guess within a code or so, thresholds the answer.
pub struct Coder16 {
    /// Light from which code i holds; then infinity.
    thresholds: Vec<f32>,
    /// Codes at the ends of the pieces that the leading bits of a float name.
    guess: Vec<f32>,
}

impl Coder16 {
    /// For light as shares of the range from black to white; `None` for HLG.
    pub fn new(transfer: &Transfer, (black, white): (f64, f64)) -> Option<Coder16> {
        let light = |code: f64| match transfer {
            Transfer::Pq => Some((pq_decode(code) - black) / (white - black)),
            other => other.decode(code),
        };
        let mut thresholds = vec![f32::NEG_INFINITY];
        for code in 1..=65535 {
            let exact = light((f64::from(code) - 0.5) / 65535.0)?;
            let near = exact as f32;
            thresholds.push(if f64::from(near) < exact { near.next_up() } else { near });
        }
        thresholds.push(f32::INFINITY);
        let last = (1.0f32.to_bits() >> SHIFT) + 1;
        let code = |i| {
            let x = f64::from(f32::from_bits(i << SHIFT)).min(1.0);
            (transfer.encode([x; 3], (black, white), [0.0; 3])[0] * 65535.0) as f32
        };
        Some(Coder16 { thresholds, guess: (0..=last).map(code).collect() })
    }

    /// The code nearest to the display value of `linear`; that of 0 for NaN and below, of 1 above 1.
    #[inline]
    pub fn code(&self, linear: f32) -> u16 {
        let x = bound(linear, 0.0, 1.0);
        let bits = x.to_bits();
        let at = (bits >> SHIFT) as usize;
        let part = (bits & ((1 << SHIFT) - 1)) as f32 / (1 << SHIFT) as f32;
        let guess = self.guess[at] + (self.guess[at + 1] - self.guess[at]) * part;
        let mut code = (guess + 0.5) as usize & 0xffff;
        while x < self.thresholds[code] {
            code -= 1;
        }
        while x >= self.thresholds[code + 1] {
            code += 1;
        }
        code as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_16_bits_are_those_of_the_formula() {
        let table = (0..=16).map(|i| (f64::from(i) / 16.0).powf(1.8)).collect();
        for t in [Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(0.4), Transfer::Pq, Transfer::Table(table)] {
            let coder = Coder16::new(&t, (0.005, 1000.0)).unwrap();
            for i in 0..300_000 {
                let x = i as f32 / 299_999.0;
                for x in [x, x * x * x * x] {
                    let want = t.encode([f64::from(x); 3], (0.005, 1000.0), [0.0; 3])[0] * 65535.0;
                    let got = f64::from(coder.code(x));
                    // A hair more where the sRGB curve's two parts meet.
                    assert!((got - want).abs() <= 0.5 + 2e-3, "{t:?} {x}: {got} for {want}");
                }
            }
            assert_eq!([-1.0, f32::NAN].map(|x| coder.code(x)), [coder.code(0.0); 2]);
            assert_eq!([2.0, f32::INFINITY].map(|x| coder.code(x)), [coder.code(1.0); 2]);
        }
    }

    #[test]
    fn codes_are_those_of_the_formula() {
        let coder = Coder8::new(&Transfer::Srgb).unwrap();
        for i in 0..200_000 {
            let x = i as f32 / 199_999.0;
            let want = srgb_encode(f64::from(x)) * 255.0;
            let got = f64::from(coder.code(x));
            assert!((got - want).abs() <= 0.5 + 1e-5, "{x}: {got} for {want}");
        }
        assert_eq!([-1.0, f32::NAN, 2.0, f32::INFINITY].map(|x| coder.code(x)), [0, 0, 255, 255]);
        for code in 0..=255u8 {
            assert_eq!(coder.code(srgb_decode(f64::from(code) / 255.0) as f32), code);
        }
    }

    #[test]
    fn every_curve_rises_from_black_to_white() {
        let table = (0..=16).map(|i| (f64::from(i) / 16.0).powf(1.8)).collect();
        for t in [Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Pq, Transfer::Hlg, Transfer::Table(table)] {
            let code = |x: f64| t.encode([x; 3], (0.01, 1000.0), [0.2627, 0.678, 0.0593])[1];
            assert!((0..1000).all(|i| code(f64::from(i) / 1000.0) < code(f64::from(i + 1) / 1000.0)), "{t:?}");
            if t != Transfer::Pq {
                let rgb = [0.3, 0.01, 0.4];
                let y = [0.2627, 0.678, 0.0593];
                let back = t.light(t.encode(rgb, (0.01, 1000.0), y), (0.01, 1000.0), y);
                assert!(back.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 1e-9), "{t:?}: {back:?}");
                assert!(code(0.0).abs() < 1e-9 && (code(1.0) - 1.0).abs() < 1e-7, "{t:?}: {}", code(1.0));
            }
        }
        assert!((pq_decode(pq_encode(123.4)) - 123.4).abs() < 1e-9);
    }
}
