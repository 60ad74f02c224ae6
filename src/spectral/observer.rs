//! Standard observers: three colour matching functions [CIE15].

use super::{Spectrum, builtin};
use crate::Result;

/// Colour matching functions, 1 nm tables.
#[derive(Clone, Debug)]
pub struct Observer {
    /// xbar, ybar, zbar.
    pub cmf: [Spectrum; 3],
}

impl Observer {
    /// CIE 1931, 2 degrees: the one that luminance and every figure of the paper use.
    pub fn cie1931() -> Result<Observer> {
        Observer::builtin("cie1931")
    }

    /// CIE 1964, 10 degrees.
    pub fn cie1964() -> Result<Observer> {
        Observer::builtin("cie1964")
    }

    fn builtin(name: &str) -> Result<Observer> {
        let channel = |c: &str| builtin::spectrum(&format!("{name}_{c}"));
        Ok(Observer { cmf: [channel("x")?, channel("y")?, channel("z")?] })
    }

    /// Eq. (4): the integral of `s` x CMF, both linear between their points, without the factor 683.
    ///
    /// ```
    /// use luxpipe::spectral::{Observer, Spectrum};
    /// let y = Observer::cie1931().unwrap().integrate(&Spectrum::Constant(1.0))[1];
    /// assert!((y - luxpipe::units::YBAR_INTEGRAL_NM).abs() < 1e-3);
    /// ```
    pub fn integrate(&self, s: &Spectrum) -> [f64; 3] {
        self.cmf.each_ref().map(|c| c.product_integral(s, 0.0, f64::INFINITY))
    }
}
