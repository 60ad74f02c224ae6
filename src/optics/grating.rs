//! Gratings: orders m of light that comes back from rulings of a period d, sin(out) + sin(in) = m lambda / d at right angles to
//! the rulings; along them nothing changes (conical mounting). Orders whose sine would be above 1 are evanescent and carry no
//! power.

/// Angle of an order on the other side of the normal, degrees; `None` where it is evanescent.
///
/// ```
/// use luxpipe::optics::grating::order_deg;
/// assert!((order_deg(30.0, 1, 550.0, 1600.0).unwrap() + 8.9892993).abs() < 1e-6);
/// assert!(order_deg(0.0, 3, 550.0, 1600.0).is_none());
/// ```
pub fn order_deg(incidence_deg: f64, order: i32, lambda_nm: f64, pitch_nm: f64) -> Option<f64> {
    let sin = f64::from(order) * lambda_nm / pitch_nm - incidence_deg.to_radians().sin();
    (sin.abs() <= 1.0).then(|| sin.asin().to_degrees())
}

/// Shares of the orders -most..=most of rectangular grooves of this depth, half as wide as their period, by scalar theory: the
/// mirror's order has cos^2(p / 2), odd ones (2 / (pi m))^2 sin^2(p / 2), p = 4 pi depth cos / lambda. They sum to 1 over all orders.
///
/// ```
/// use luxpipe::optics::grating::lamellar;
/// // A quarter of the wavelength deep: nothing is left of the mirror, 40.5 % goes to each first order.
/// let [minus, zero, plus] = lamellar(137.5, 1.0, 550.0, 1)[..] else { panic!() };
/// assert!(zero < 1e-12 && minus == plus && (plus - 0.405284735).abs() < 1e-9);
/// ```
pub fn lamellar(depth_nm: f64, cos: f64, lambda_nm: f64, most: i32) -> Vec<f64> {
    let half = std::f64::consts::TAU * depth_nm * cos / lambda_nm;
    let share = |m: i32| match m {
        0 => half.cos().powi(2),
        m if m % 2 == 0 => 0.0,
        m => (2.0 / (std::f64::consts::PI * f64::from(m)) * half.sin()).powi(2),
    };
    (-most..=most).map(share).collect()
}
