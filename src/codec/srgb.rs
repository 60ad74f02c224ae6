//! The sRGB transfer function [IEC 61966-2-1], exact to the code.

use crate::simd::bound;

/// Display value 0..1 for linear light 0..1.
///
/// ```
/// assert!((luxpipe::codec::srgb::encode(0.214_041_14) - 0.5).abs() < 1e-7);
/// ```
pub fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear light 0..1 for a display value 0..1.
pub fn decode(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Linear light to the nearest code of 8 bits: the leading bits of the float give a first guess, thresholds between codes
/// the answer, so that no power is computed a pixel.
pub struct Coder8 {
    /// Light from which code i holds, i = 0..255; then infinity.
    thresholds: [f32; 257],
    guess: Vec<u8>,
}

/// Bits of the float that index the guess: exponent and six of mantissa.
const SHIFT: u32 = 23 - 6;

impl Default for Coder8 {
    fn default() -> Self {
        let mut thresholds = [f32::INFINITY; 257];
        thresholds[0] = f32::NEG_INFINITY;
        for (code, t) in thresholds.iter_mut().enumerate().take(256).skip(1) {
            *t = decode((code as f64 - 0.5) / 255.0) as f32;
        }
        let last = 1.0f32.to_bits() >> SHIFT;
        let guess = (0..=last).map(|i| {
            let x = f32::from_bits(i << SHIFT);
            (thresholds[1..256].partition_point(|t| *t <= x)) as u8
        });
        Coder8 { thresholds, guess: guess.collect() }
    }
}

impl Coder8 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_the_formula() {
        let coder = Coder8::default();
        for i in 0..200_000 {
            let x = i as f32 / 199_999.0;
            let want = encode(f64::from(x)) * 255.0;
            let got = f64::from(coder.code(x));
            assert!((got - want).abs() <= 0.5 + 1e-5, "{x}: {got} for {want}");
        }
        assert_eq!([-1.0, f32::NAN, 2.0, f32::INFINITY].map(|x| coder.code(x)), [0, 0, 255, 255]);
        for code in 0..=255u8 {
            assert_eq!(coder.code(decode(f64::from(code) / 255.0) as f32), code);
        }
    }
}
