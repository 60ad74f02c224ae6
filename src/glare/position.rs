//! How much a glare source disturbs by where it is: the position index P, 1 on the line of sight and more beside it.
//!
//! Above the line of sight it is Guth's, in Levin's formula [Levin 1975]; with t the angle from straight up of the plane
//! through the source and the line of sight, s the angle of the source from the line of sight, both in degrees:
//!
//! ln P = (35.2 - 0.31889 t - 1.22 exp(-2 t / 9)) s / 1000 + (21 + 0.26667 t - 0.002963 t^2) s^2 / 100000
//!
//! Below it [Iwata 2010], which replaced the two straight lines of [Iwata 1997] that did not meet Guth's index at eye level:
//! the same with t = 90, of a source moved 1.15 times as far down in the plane before the eye. The 1.15 is read off what
//! evalglare 3.06 prints for sources in 14 directions, within 0.5 %. P is at most 16, as there.

/// Largest index, beyond which Guth's subjects saw nothing.
const LARGEST: f64 = 16.0;
/// How much further down a source below the line of sight counts [Iwata 2010].
const BELOW: f64 = 1.15;

/// Position index of a direction (right, up, along the line of sight), of any length. Behind the eye it is the largest.
///
/// ```
/// use luxpipe::glare::position::index;
/// let degrees = |t: f64| t.to_radians();
/// assert_eq!(index([0.0, 0.0, 1.0]), 1.0);
/// // 20 degrees up: ln P = (35.2 - 1.22) 0.020 + 21e-5 x 400 = 0.7636
/// assert!((index([0.0, degrees(20.0).sin(), degrees(20.0).cos()]) - 2.1460).abs() < 1e-4);
/// // 30 degrees beside: ln P = 6.4999 x 0.030 + 21.0000e-5 x 900 = 0.38400
/// assert!((index([0.5, 0.0, degrees(30.0).cos()]) - 1.46814).abs() < 1e-4);
/// ```
pub fn index(direction: [f64; 3]) -> f64 {
    let [x, y, z] = direction;
    if z <= 0.0 {
        return LARGEST;
    }
    let (up, tau) = if y < 0.0 { (BELOW * y, 90.0) } else { (y, x.abs().atan2(y).to_degrees()) };
    let sigma = x.hypot(up).atan2(z).to_degrees();
    let linear = 35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp();
    let square = 21.0 + 0.26667 * tau - 0.002963 * tau * tau;
    (linear * sigma / 1e3 + square * sigma * sigma / 1e5).exp().clamp(1.0, LARGEST)
}
