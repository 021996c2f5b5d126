use super::*;

const FRAME: f64 = 1.0 / 60.0;

/// A cloth whose error is `load / n^2`, at once.
fn settled(quality: Quality, start: u32, frames: u32, load: impl Fn(u32) -> f64) -> Vec<u32> {
    let mut chooser = Chooser::default();
    let mut n = start;
    let frame = |frame| {
        n = chooser.next(quality, n);
        chooser.measured(load(frame) / f64::from(n * n));
        chooser.stepped(FRAME);
        n
    };
    (0..frames).map(frame).collect()
}

/// A host whose clock shows `0.2 + cost n` ms for a frame of n steps.
fn timed(quality: Quality, start: u32, frames: u32, cost: impl Fn(u32) -> f64) -> Vec<u32> {
    let mut chooser = Chooser::default();
    let mut n = start;
    let frame = |frame| {
        n = chooser.next(quality, n);
        chooser.measured(1.0);
        chooser.stepped(FRAME);
        chooser.took(n, 0.2 + cost(frame) * f64::from(n));
        n
    };
    (0..frames).map(frame).collect()
}

#[test]
fn an_error_is_met_with_few_substeps_more_than_it_needs() {
    // 20 and 45 substeps leave just 5 % and 1 % of a load of 20.
    for (target, least) in [(0.05, 20), (0.01, 45)] {
        for start in [1, 8, 200] {
            let all = settled(Quality::Error(target), start, 900, |_| 20.0);
            let end = all[899];
            assert!(all[600..].iter().all(|n| *n == end), "{target} from {start}: {:?}", &all[600..]);
            assert!((least..=least + least / 6).contains(&end), "{target} from {start}: {end}");
            assert!(all.windows(2).all(|n| n[1] <= n[0] + (n[0] / 4).max(1) && n[1] + n[0].div_ceil(8) >= n[0]));
        }
    }
}

#[test]
fn it_rises_soon_and_falls_with_patience() {
    let all = settled(Quality::Error(0.02), 8, 1200, |frame| if (300..600).contains(&frame) { 50.0 } else { 5.0 });
    let (calm, hard) = (all[299], all[599]);
    assert!(hard >= 50 && calm <= 19 && all[1199] == calm, "{calm} {hard} {}", all[1199]);
    assert!(all[300..360].contains(&hard));
    assert!(!all[600..660].contains(&calm));
}

#[test]
fn a_budget_is_kept_by_the_clock_of_the_host() {
    // 4 ms: 38 steps of 0.1 ms, 19 of 0.2 ms.
    let all = timed(Quality::Budget(4.0), 8, 1200, |frame| if frame < 600 { 0.1 } else { 0.2 });
    assert!((34..=38).contains(&all[599]), "{}", all[599]);
    assert!((16..=19).contains(&all[1199]), "{}", all[1199]);
    // Within some frames of the change.
    assert!(all[620..].iter().all(|n| 0.2 + 0.2 * f64::from(*n) <= 4.01), "{:?}", &all[600..640]);
    // Nothing is known before the clock has been read.
    assert!(settled(Quality::Budget(4.0), 8, 100, |_| 1.0).iter().all(|n| *n == 8));
    // Nothing fits.
    assert_eq!(timed(Quality::Budget(0.01), 8, 60, |_| 1.0)[59], 1);
}

#[test]
fn the_budget_wins_and_fixed_is_fixed() {
    // The stretch of 100 % never ends.
    let both = Quality::ErrorWithin { stretch: 0.01, ms: 4.0 };
    let all = timed(both, 8, 600, |_| 0.1);
    assert!(all[300..].iter().all(|n| (34..=38).contains(n)), "{:?}", &all[300..]);
    assert!(timed(Quality::Error(0.01), 8, 600, |_| 0.1)[599] == MOST);
    assert!(timed(Quality::Fixed, 8, 100, |_| 9.0).iter().all(|n| *n == 8));
}

#[test]
fn settings_out_of_range_are_refused() {
    let wrong = [Quality::Budget(0.0), Quality::Budget(f64::NAN), Quality::Error(0.0), Quality::Error(1.5)];
    let both = [Quality::ErrorWithin { stretch: 0.1, ms: -1.0 }, Quality::ErrorWithin { stretch: 2.0, ms: 1.0 }];
    for quality in wrong.into_iter().chain(both) {
        assert!(quality.check().is_err(), "{quality:?}");
    }
    assert!(Quality::ErrorWithin { stretch: 0.01, ms: 2.0 }.check().is_ok());
}
