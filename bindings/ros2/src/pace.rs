//! When to step and when to publish: wall time against simulated time.

use std::time::{Duration, Instant};

/// Lag that is made up for by running faster for a while; beyond it the lost time is given up \[s\].
const LARGEST_LAG: f64 = 0.1;

/// Span over which the real-time factor is measured \[s\].
const WINDOW: f64 = 0.5;

/// Ties simulated to wall time. Due times are counted from one anchor, so that they do not drift.
#[derive(Debug, Clone)]
pub struct Pace {
    /// Real-time factor asked for; 0 for as fast as it can.
    factor: f64,
    anchor: (Instant, f64),
    window: (Instant, f64),
    measured: f64,
    /// Wall time given up since the start \[s\].
    pub lost: f64,
}

impl Pace {
    /// From now and here on.
    pub fn new(factor: f64, now: Instant, time: f64) -> Self {
        Self { factor, anchor: (now, time), window: (now, time), measured: 0.0, lost: 0.0 }
    }

    /// Goes on from now and here: after a pause, a jump in time or another factor.
    pub fn restart(&mut self, factor: f64, now: Instant, time: f64) {
        *self = Self { lost: self.lost, ..Self::new(factor, now, time) };
    }

    /// The wall time at which `time` is due; `None` if that is at once.
    pub fn due(&self, time: f64) -> Option<Instant> {
        let after = (time - self.anchor.1) / self.factor;
        (self.factor > 0.0).then(|| self.anchor.0 + Duration::try_from_secs_f64(after.max(0.0)).unwrap_or(Duration::MAX / 4))
    }

    /// Notes that `time` was reached `now`. Returns the wall time given up \[s\] where it is too late to be made up for.
    pub fn reached(&mut self, now: Instant, time: f64) -> Option<f64> {
        let wall = (now - self.window.0).as_secs_f64();
        if wall >= WINDOW {
            self.measured = (time - self.window.1) / wall;
            self.window = (now, time);
        }
        let lag = now.saturating_duration_since(self.due(time)?).as_secs_f64();
        if lag <= LARGEST_LAG {
            return None;
        }
        self.anchor = (now, time);
        self.lost += lag;
        Some(lag)
    }

    /// What is said when `lost` seconds of wall time were given up.
    pub fn behind(&self, lost: f64) -> String {
        let (asked, reached) = (self.factor, self.measured);
        format!("cannot keep a real-time factor of {asked}: it is {reached:.3} of late; {lost:.2} s of wall time given up")
    }

    /// Real-time factor of late \[-\]; 0 until it is known.
    pub fn measured(&self) -> f64 {
        self.measured
    }
}

/// Publishes at a rate: at whole multiples of a period of simulated time where time is tied to the wall, by the wall where it is not.
#[derive(Debug, Clone, Default)]
pub struct Ticker {
    last: Option<i64>,
    next: Option<Instant>,
}

impl Ticker {
    /// Whether it is time to publish. `rate` in Hz of wall time, 0 for always; `factor` as asked for, 0 for as fast as it can.
    pub fn due(&mut self, rate: f64, factor: f64, now: Instant, time: f64) -> bool {
        if rate == 0.0 {
            return true;
        }
        if factor > 0.0 {
            let tick = (time * rate / factor + 1e-6).floor() as i64;
            return self.last.replace(tick) != Some(tick);
        }
        let due = self.next.is_none_or(|next| now >= next);
        if due {
            self.next = Some(now + Duration::from_secs_f64(1.0 / rate));
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(s: f64) -> Duration {
        Duration::from_secs_f64(s)
    }

    #[test]
    fn due_times_do_not_drift() {
        let start = Instant::now();
        let pace = Pace::new(2.0, start, 1.0);
        assert_eq!(pace.due(1.0), Some(start));
        // A million steps of 1 ms at twice the wall's pace are 500 s.
        let late = pace.due(1.0 + 1e6 * 1e-3).unwrap() - start;
        assert!((late.as_secs_f64() - 500.0).abs() < 1e-9);
        assert_eq!(Pace::new(0.0, start, 0.0).due(9.0), None);
    }

    #[test]
    fn a_short_lag_is_made_up_for_and_a_long_one_given_up() {
        let start = Instant::now();
        let mut pace = Pace::new(1.0, start, 0.0);
        assert_eq!(pace.reached(start + seconds(1.05), 1.0), None);
        assert_eq!(pace.due(2.0), Some(start + seconds(2.0)), "no time was lost");
        let lost = pace.reached(start + seconds(2.5), 2.0).unwrap();
        assert!((lost - 0.5).abs() < 1e-9);
        assert_eq!(pace.due(3.0), Some(start + seconds(3.5)));
        assert!((pace.lost - 0.5).abs() < 1e-9);
        assert!((pace.measured() - 1.0 / 1.45).abs() < 1e-6);
    }

    #[test]
    fn ticks_are_multiples_of_simulated_time() {
        let (start, mut ticker) = (Instant::now(), Ticker::default());
        let mut count = |rate, factor| (0..=300).filter(|i| ticker.due(rate, factor, start, f64::from(*i) * 0.01)).count();
        assert_eq!(count(10.0, 1.0), 31);
        assert_eq!(count(100.0, 1.0), 301);
        assert_eq!(count(0.0, 1.0), 301);
        let mut ticker = Ticker::default();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let fired = (0..100).filter(|ms| ticker.due(100.0, 0.0, at(*ms), 0.0)).count();
        assert_eq!(fired, 10);
    }
}
