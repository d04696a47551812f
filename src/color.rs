//! One colour map for every picture: viridis, even in brightness and safe for the colour-blind.

/// Samples at equal distances.
const VIRIDIS: [[u8; 3]; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// Colour (red, green, blue) for a share from 0 to 1; anything outside takes the nearer end, NaN the lower one.
pub(crate) fn viridis(share: f64) -> [u8; 3] {
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let x = share * (VIRIDIS.len() - 1) as f64;
    let i = (x as usize).min(VIRIDIS.len() - 2);
    let (low, high) = (VIRIDIS[i], VIRIDIS[i + 1]);
    std::array::from_fn(|k| (f64::from(low[k]) + (x - i as f64) * (f64::from(high[k]) - f64::from(low[k]))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_outside() {
        assert_eq!(viridis(-1.0), VIRIDIS[0]);
        assert_eq!(viridis(0.5), VIRIDIS[8]);
        assert_eq!(viridis(2.0), VIRIDIS[16]);
        assert_eq!(viridis(f64::NAN), VIRIDIS[0]);
    }
}
