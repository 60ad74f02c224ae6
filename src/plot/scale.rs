//! Axes: from values to places, and the ticks of a range.

/// How values lie along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Even steps for even differences.
    #[default]
    Linear,
    /// Even steps for even ratios; values above 0 only.
    Log,
}

/// What no axis goes beyond: sums and ratios of such numbers are finite.
const LARGEST: f64 = 1e100;

impl Scale {
    /// The value has a place on such an axis; numbers beyond 1e100 have none.
    pub fn takes(self, value: f64) -> bool {
        value.abs() <= LARGEST && (self == Scale::Linear || value >= 1.0 / LARGEST)
    }

    fn warp(self, value: f64) -> f64 {
        if self == Scale::Log { value.log10() } else { value }
    }

    fn unwarp(self, value: f64) -> f64 {
        if self == Scale::Log { 10f64.powf(value) } else { value }
    }
}

/// An axis with its ends settled.
#[derive(Clone, Copy, Debug)]
pub struct Ruler {
    scale: Scale,
    /// First and last value, first below last.
    pub range: (f64, f64),
    /// Pixels of the first and the last value.
    pub pixels: (f64, f64),
}

/// A tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where, in the axis' unit.
    pub value: f64,
    /// Its number; none at a minor tick.
    pub label: Option<String>,
}

/// Decades that still get ticks between them.
const MINOR_DECADES: f64 = 10.0;

impl Ruler {
    /// An axis whose `range` is ascending, and positive on a logarithmic one.
    pub fn new(scale: Scale, range: (f64, f64)) -> Ruler {
        Ruler { scale, range, pixels: (0.0, 1.0) }
    }

    /// Pixel of a value, ends at their pixels.
    pub fn place(&self, value: f64) -> f64 {
        let (a, b) = (self.scale.warp(self.range.0), self.scale.warp(self.range.1));
        let (from, to) = self.pixels;
        from + (to - from) * (self.scale.warp(value) - a) / (b - a)
    }

    /// Ticks, at most about `count` of them with a number.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.even(count),
            Scale::Log => self.decades(count),
        }
    }

    fn even(&self, count: usize) -> Vec<Tick> {
        let (a, b) = self.range;
        let slack = 1e-9 * (b - a);
        let steps = (count.max(1)..).map(|n| nice_step((b - a) / n as f64));
        let ends = |step: f64| (((a - slack) / step).ceil(), ((b + slack) / step).floor());
        // Two numbers at least: one says nothing of the scale.
        let step = steps.take(20).find(|step| ends(*step).1 - ends(*step).0 >= 1.0).unwrap_or(b - a);
        let (first, last) = ends(step);
        let ticks = (0..=(last - first).clamp(0.0, 200.0) as u32).map(|i| {
            let value = (first + f64::from(i)) * step;
            Tick { value, label: Some(number(value, step)) }
        });
        ticks.collect()
    }

    fn decades(&self, count: usize) -> Vec<Tick> {
        let span = self.range.1.log10() - self.range.0.log10();
        let every = (span / count.max(1) as f64).ceil().max(1.0) as i32;
        // Few decades leave room for numbers between them.
        let digits: &[&[u32]] = if span < 0.5 {
            &[]
        } else if span <= 1.05 && count >= 6 {
            &[&[1, 2, 3, 5]]
        } else if span * 3.0 <= count as f64 + 0.5 {
            &[&[1, 2, 5]]
        } else {
            &[&[1], &[1, 2, 5]]
        };
        let ticks = digits.iter().map(|d| self.decades_at(d, every, span <= MINOR_DECADES));
        let tells = |ticks: &Vec<Tick>| ticks.iter().filter(|t| t.label.is_some()).count() >= 2;
        ticks.into_iter().find(tells).unwrap_or_else(|| self.even(count))
    }

    /// Ticks with numbers at these digits of each `every`th decade; without, at the others.
    fn decades_at(&self, digits: &[u32], every: i32, minor: bool) -> Vec<Tick> {
        let (low, high) = (self.range.0.log10(), self.range.1.log10());
        let slack = 1e-9 * (high - low).max(1.0);
        let mut ticks = Vec::new();
        for exponent in low.floor() as i32..=high.ceil() as i32 {
            for digit in 1..10u32 {
                let value = power(digit, exponent);
                let label = digits.contains(&digit) && exponent.rem_euclid(every) == 0;
                let shown = value.log10() >= low - slack && value.log10() <= high + slack;
                if shown && (label || digit == 1 || minor) {
                    ticks.push(Tick { value, label: label.then(|| decade_number(digit, exponent)) });
                }
            }
        }
        ticks
    }
}

/// The digit x 10^exponent, correctly rounded as its text is.
fn power(digit: u32, exponent: i32) -> f64 {
    format!("{digit}e{exponent}").parse().unwrap_or(f64::NAN) // always a number
}

/// 1, 2 or 5 x 10^k, not below `least`.
pub fn nice_step(least: f64) -> f64 {
    let exponent = least.log10().floor() as i32;
    let steps = [power(1, exponent), power(2, exponent), power(5, exponent)];
    steps.into_iter().find(|s| *s >= least * (1.0 - 1e-9)).unwrap_or(power(1, exponent + 1))
}

/// The range rounded outward: to steps on a linear axis, to 1, 2 or 5 x 10^k on a logarithmic one.
pub fn rounded(scale: Scale, range: (f64, f64), count: usize) -> (f64, f64) {
    let (a, b) = range;
    match scale {
        Scale::Linear => {
            let step = nice_step((b - a) / count.max(1) as f64);
            ((a / step + 1e-9).floor() * step, (b / step - 1e-9).ceil() * step)
        }
        Scale::Log => {
            let all = |e: i32| [1, 2, 5].map(|d| power(d, e));
            let around = |v: f64| (v.log10().floor() as i32 - 1..=v.log10().floor() as i32 + 1).flat_map(all);
            let low = around(a).rfind(|v| *v <= a * (1.0 + 1e-9));
            let high = around(b).find(|v| *v >= b * (1.0 - 1e-9));
            let ends = (low.unwrap_or(a), high.unwrap_or(b));
            if scale.takes(ends.0) && scale.takes(ends.1) { ends } else { range }
        }
    }
}

/// The range a little longer where `data` reach its end, so that no curve runs along the edge; zero stays an end.
pub fn aired(scale: Scale, range: (f64, f64), data: (f64, f64)) -> (f64, f64) {
    let (a, b) = (scale.warp(range.0), scale.warp(range.1));
    let air = 0.03 * (b - a);
    let kept = |end: f64| scale == Scale::Linear && end == 0.0;
    let low = if scale.warp(data.0) - a < 0.5 * air && !kept(range.0) { scale.unwarp(a - air) } else { range.0 };
    let high = if b - scale.warp(data.1) < 0.5 * air && !kept(range.1) { scale.unwarp(b + air) } else { range.1 };
    if scale.takes(low) && scale.takes(high) { (low, high) } else { range }
}

/// A range that has a width, about one that has none.
pub fn widened(scale: Scale, range: (f64, f64)) -> (f64, f64) {
    let (a, b) = range;
    // Closer than floats can tell apart on paper.
    if b - a > 1e-9 * a.abs().max(b.abs()) {
        return range;
    }
    match scale {
        Scale::Log => (a / 2.0, b * 2.0),
        Scale::Linear if a == 0.0 => (-1.0, 1.0),
        Scale::Linear => (a - 0.1 * a.abs(), b + 0.1 * b.abs()),
    }
}

/// A number with the decimals that its step needs.
fn number(value: f64, step: f64) -> String {
    let largest = value.abs();
    if largest >= 0.999_999e6 || (largest > 0.0 && step < 0.999_999e-4) {
        let exponent = largest.log10().floor() as i32;
        let decimals = (exponent - step.log10().floor() as i32).clamp(0, 12) as usize;
        let mantissa = format!("{:.decimals$}", value / 10f64.powi(exponent));
        return minus(&format!("{mantissa}×10{}", superscript(exponent)));
    }
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.decimals$}");
    minus(if text.trim_start_matches(['-', '0', '.']).is_empty() { text.trim_start_matches('-') } else { &text })
}

/// digit x 10^exponent in the shortest form.
fn decade_number(digit: u32, exponent: i32) -> String {
    match exponent {
        0..4 => format!("{digit}{}", "0".repeat(exponent as usize)),
        -3..0 => format!("0.{}{digit}", "0".repeat((-exponent - 1) as usize)),
        _ if digit == 1 => format!("10{}", superscript(exponent)),
        _ => format!("{digit}×10{}", superscript(exponent)),
    }
}

fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

/// A whole number in raised digits.
pub fn superscript(n: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        d => char::from_u32(0x2070 + d as u32 - '0' as u32).unwrap_or(d),
    };
    n.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(scale: Scale, range: (f64, f64), count: usize) -> Vec<String> {
        Ruler::new(scale, range).ticks(count).into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(Scale::Linear, (0.0, 1.0), 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Scale::Linear, (-20.0, 20.0), 4), ["−20", "−10", "0", "10", "20"]);
        assert_eq!(labels(Scale::Linear, (380.0, 780.0), 5), ["400", "500", "600", "700"]);
        assert_eq!(labels(Scale::Log, (0.01, 1e4), 8), ["0.01", "0.1", "1", "10", "100", "1000", "10⁴"]);
        assert_eq!(labels(Scale::Log, (1e-9, 1e9), 6), ["10⁻⁹", "10⁻⁶", "0.001", "1", "1000", "10⁶", "10⁹"]);
        assert_eq!(labels(Scale::Log, (1.0, 100.0), 6), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(labels(Scale::Log, (0.99, 1.01), 4), ["0.990", "0.995", "1.000", "1.005", "1.010"]);
        assert_eq!(labels(Scale::Log, (0.5, 5.0), 2), ["0.5", "1", "2", "5"]);
    }

    proptest! {
        #[test]
        fn any_range_has_ticks_within_it(a in -1e12f64..1e12, w in 1e-6f64..1e12, log in any::<bool>(), n in 2usize..12) {
            let scale = if log { Scale::Log } else { Scale::Linear };
            let a = if log { a.abs() + 1e-9 } else { a };
            let range = rounded(scale, widened(scale, (a, a + w)), n);
            prop_assert!(range.0 < range.1 && range.0 <= a && range.1 >= a + w * (1.0 - 1e-6), "{range:?}");
            let ruler = Ruler::new(scale, range);
            let ticks = ruler.ticks(n);
            prop_assert!(ticks.iter().filter(|t| t.label.is_some()).count() >= 2, "{range:?} {ticks:?}");
            for t in ticks {
                prop_assert!((-1e-6..=1.0 + 1e-6).contains(&ruler.place(t.value)), "{t:?} in {range:?}");
            }
        }
    }
}
