//! Numbers and tables for people: what the command line and other adapters print.

/// A value with an SI prefix and four digits: `1.235 ms`. A unit that begins with a prefix (kg) takes no second one.
pub fn si(value: f64, unit: &str) -> String {
    if unit.starts_with("kg") {
        return format!("{} {unit}", digits(value));
    }
    const PREFIXES: [(f64, &str); 8] = [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
    // What is rounded up to the next prefix takes it: 1 ms, not 1000 µs.
    match PREFIXES.into_iter().find(|(factor, _)| value.abs() >= 0.999_95 * factor) {
        Some((factor, prefix)) => format!("{} {prefix}{unit}", digits(value / factor)).trim_end().to_owned(),
        None => format!("{} {unit}", digits(value)).trim_end().to_owned(),
    }
}

/// Four significant digits without trailing zeros.
pub fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// How fast particles are stepped.
pub fn rate(particle_steps_a_second: f64) -> String {
    format!("{} million particle-steps/s", digits(1e-6 * particle_steps_a_second))
}

/// Memory in binary units.
pub fn bytes(count: usize) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let power = UNITS.iter().enumerate().rev().map(|(i, _)| i).find(|&i| count >> (10 * i) > 0).unwrap_or(0);
    format!("{} {}", digits(count as f64 / (1u64 << (10 * power)) as f64), UNITS[power])
}

/// A duration as `0.25 s`, `12.5 s`, `3 min 20 s` or `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 60.0 => format!("{} s", digits(s)),
        s if s < 3600.0 => format!("{} min {} s", (s / 60.0) as u64, (s % 60.0) as u64),
        s => format!("{} h {} min", (s / 3600.0) as u64, (s % 3600.0 / 60.0) as u64),
    }
}

/// A number with a thin mark every three digits: `1 234 567`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Lines of a name and a value, the values below each other.
pub fn pairs<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let rows: Vec<_> = rows.into_iter().collect();
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    rows.iter().map(|(name, value)| format!("  {name:width$}  {value}\n")).collect()
}

/// A table with a header line; every column but the last is as wide as its widest cell.
pub fn table<const N: usize>(header: [&str; N], rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).chain([header[column].len()]).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(|column| if column + 1 < N { width(column) } else { 0 });
    let line = |cells: [&str; N]| {
        let cells: Vec<String> = cells.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        format!("  {}\n", cells.join("  ").trim_end())
    };
    let rows = rows.iter().map(|row| line(std::array::from_fn(|column| row[column].as_str())));
    std::iter::once(line(header)).chain(rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(si(1.23456e-3, "s"), "1.235 ms");
        assert_eq!(si(0.000_999_999, "s"), "1 ms");
        assert_eq!(si(0.0, "J"), "0 J");
        assert_eq!(si(-2.5e6, "J/m"), "-2.5 MJ/m");
        assert_eq!(si(0.01, "kg m/s"), "0.01 kg m/s");
        assert_eq!(digits(1e-17), "1e-17");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(bytes(0), "0 B");
        assert_eq!(grouped(1234567), "1 234 567");
        assert_eq!(duration(200.0), "3 min 20 s");
    }
}
