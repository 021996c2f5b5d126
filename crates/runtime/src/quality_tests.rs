use super::super::reach::MAX_ROUNDS;
use super::*;

const FRAME: f64 = 1.0 / 60.0;

/// Substeps alone.
const SUBSTEPS: Levers = Levers { round: None, start: 0, fewest: 1 };

/// Both.
const fn both(round: f64) -> Levers {
    Levers { round: Some(round), start: 0, fewest: 1 }
}

/// The mixes of a cloth whose error at a frame with a mix is known, and which shows `answer` of a change per frame.
fn mixes(
    target: f64,
    start: Mix,
    frames: u32,
    (levers, answer): (&Levers, f64),
    error: impl Fn(u32, Mix) -> f64,
) -> Vec<Mix> {
    let mut chooser = Chooser::default();
    let (mut mix, mut shown) = (start, None);
    let frame = |frame| {
        mix = chooser.next(Quality::Error(target), mix, levers);
        let error = error(frame, mix).ln();
        let before = shown.unwrap_or(error);
        shown = Some(before + answer * (error - before));
        chooser.measured((before + answer * (error - before)).exp());
        chooser.stepped(FRAME);
        mix
    };
    (0..frames).map(frame).collect()
}

/// A cloth whose error is `load / n^2`, at once.
fn settled(target: f64, start: u32, frames: u32, load: impl Fn(u32) -> f64) -> Vec<u32> {
    let start = Mix { substeps: start, rounds: 0 };
    let error = |frame, mix: Mix| load(frame) / f64::from(mix.substeps * mix.substeps);
    mixes(target, start, frames, (&SUBSTEPS, 1.0), error).iter().map(|mix| mix.substeps).collect()
}

/// A host whose clock shows `0.2 + cost n` ms for a frame of n steps.
fn timed(quality: Quality, start: u32, frames: u32, cost: impl Fn(u32) -> f64) -> Vec<u32> {
    let mut chooser = Chooser::default();
    let mut mix = Mix { substeps: start, rounds: 0 };
    let frame = |frame| {
        mix = chooser.next(quality, mix, &SUBSTEPS);
        chooser.measured(1.0);
        chooser.stepped(FRAME);
        chooser.took(mix.substeps, 0.2 + cost(frame) * f64::from(mix.substeps));
        mix.substeps
    };
    (0..frames).map(frame).collect()
}

#[test]
fn an_error_is_met_with_few_substeps_more_than_it_needs() {
    // 20 and 45 substeps leave just 5 % and 1 % of a load of 20.
    for (target, least) in [(0.05, 20), (0.01, 45)] {
        for start in [1, 8, 200] {
            let all = settled(target, start, 900, |_| 20.0);
            let end = all[899];
            assert!(all[600..].iter().all(|n| *n == end), "{target} from {start}: {:?}", &all[600..]);
            assert!((least..=least + least / 6).contains(&end), "{target} from {start}: {end}");
            assert!(all.windows(2).all(|n| n[1] <= n[0] + (n[0] / 4).max(1) && n[1] + n[0].div_ceil(8) >= n[0]));
        }
    }
}

#[test]
fn it_rises_soon_and_falls_with_patience() {
    let all = settled(0.02, 8, 1200, |frame| if (300..600).contains(&frame) { 50.0 } else { 5.0 });
    let (calm, hard) = (all[299], all[599]);
    assert!(hard >= 50, "{hard}");
    // 16 just meet the target. The exponents that were learned on the way decide how many more there are, so that a load leads
    // to 17 or 18 by its history.
    for end in [200..300, 1100..1200] {
        let all = &all[end];
        assert!(
            (16..=18).contains(&calm) && all.iter().all(|n| n.abs_diff(calm) <= 1 && *n == all[0]),
            "{calm} {all:?}"
        );
    }
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
    let mut chooser = Chooser::default();
    let start = Mix { substeps: 8, rounds: 0 };
    for _ in 0..100 {
        chooser.stepped(FRAME);
        assert_eq!(chooser.next(Quality::Budget(4.0), start, &SUBSTEPS), start);
    }
    // Nothing fits.
    assert_eq!(timed(Quality::Budget(0.01), 8, 60, |_| 1.0)[59], 1);
}

#[test]
fn a_slow_start_and_busy_moments_do_not_lower_a_budget_for_long() {
    // A first frame that takes twice as long, and moments in which all frames do; 4 ms have room for 9 steps of 0.4 ms.
    let busy = |frame: u32| frame == 0 || frame % 240 >= 230;
    let all = timed(Quality::Budget(4.0), 8, 1200, |frame| if busy(frame) { 0.8 } else { 0.4 });
    assert!(all[1..200].iter().all(|n| *n >= 6), "{:?}", &all[..40]);
    for end in [225, 465, 705, 945, 1185] {
        assert!((8..=9).contains(&all[end]), "{end}: {:?}", &all[end - 40..end]);
    }
}

#[test]
fn the_budget_wins_and_fixed_is_fixed() {
    // The stretch of 100 % never ends.
    let both = Quality::ErrorWithin { stretch: 0.01, ms: 4.0 };
    let all = timed(both, 8, 600, |_| 0.1);
    assert!(all[300..].iter().all(|n| (34..=38).contains(n)), "{:?}", &all[300..]);
    assert!(timed(Quality::Error(0.01), 8, 600, |_| 0.1)[599] == MAX_SUBSTEPS);
    assert!(timed(Quality::Fixed, 8, 100, |_| 9.0).iter().all(|n| *n == 8));
}

/// How the error falls with substeps and rounds.
type Error = fn(f64, f64) -> f64;

/// Laws, the cost of a round, and the largest error in a single substep without polish.
const LAWS: [(&str, Error, f64, f64); 8] = [
    ("as known at the start", |n, r| 1.0 / (n * n * (1.0 + r)), 0.2, 20.0),
    ("rounds are cheap", |n, r| 1.0 / (n * n * (1.0 + r)), 0.05, 20.0),
    ("crumpled", |n, r| 1.0 / (n.powf(1.2) * (1.0 + r).powf(0.9)), 0.15, 5.0),
    ("rounds bring nothing", |n, _| 1.0 / (n * n), 0.2, 20.0),
    ("rounds bring little", |n, r| 1.0 / (n * n * (1.0 + r).powf(0.2)), 0.1, 20.0),
    ("substeps bring little", |n, r| 1.0 / (n.powf(0.8) * (1.0 + r).powf(1.2)), 0.1, 10.0),
    ("rounds bring much, and then nothing", |n, r| (0.6f64.powf(r) + 0.02) / (n * n), 0.2, 50.0),
    ("substeps bring much", |n, r| 1.0 / (n.powi(3) * (1.0 + r).powf(0.8)), 0.2, 200.0),
];

/// The least cost of the mixes that meet a target.
fn cheapest(target: f64, levers: &Levers, error: impl Fn(Mix) -> f64) -> (f64, Mix) {
    let all = (0..=MAX_ROUNDS).flat_map(|rounds| (1..=MAX_SUBSTEPS).map(move |substeps| Mix { substeps, rounds }));
    let good = all.filter(|mix| error(*mix) <= target);
    good.map(|mix| (levers.cost(mix), mix)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

#[test]
fn the_cheapest_mix_is_found_by_measuring() {
    for (name, law, round, load) in LAWS {
        for (target, answer) in [(0.05, 1.0), (0.01, 1.0), (0.01, 0.2)] {
            let (levers, error) = (both(round), |mix: Mix| load * law(mix.substeps.into(), mix.rounds.into()));
            let (least, best) = cheapest(AIM * target, &levers, error);
            for (substeps, rounds) in [(8, 0), (8, 8), (100, 0), (40, 16)] {
                let start = Mix { substeps, rounds };
                let all = mixes(target, start, 10_800, (&levers, answer), |_, mix| error(mix));
                let end = all[10_799];
                let name = format!("{name}, {target} from {start:?} with {answer}: {end:?}, best {best:?}");
                let changes = all[7200..].windows(2).filter(|w| w[0] != w[1]).count();
                eprintln!("{:.3} {changes} {name}", levers.cost(end) / least);
                assert!(levers.cost(end) <= 1.15 * least, "{name}");
                assert!(error(end) <= target, "{name}: {}", error(end));
                // Of trials that do not pay and the way back.
                assert!(changes <= 8, "{name}: {:?}", &all[7200..]);
            }
        }
    }
}

#[test]
fn mixes_change_by_small_steps() {
    for (name, law, round, load) in LAWS {
        let hard = |frame| if (300..900).contains(&frame) { 3.0 } else { 1.0 };
        let error = |frame, mix: Mix| hard(frame) * load * law(mix.substeps.into(), mix.rounds.into());
        let all = mixes(0.02, Mix { substeps: 8, rounds: 2 }, 1800, (&Levers { start: 8, ..both(round) }, 1.0), error);
        for w in all.windows(2) {
            let [(n, r), (m, s)] = [w[0], w[1]].map(|mix| (mix.substeps, mix.rounds + 1));
            assert!(m <= n + (n / 4).max(1) && m + n.div_ceil(4) >= n, "{name}: {w:?}");
            assert!(s <= r + (r / 4).max(1) && s + (r / 4).max(1) >= r, "{name}: {w:?}");
        }
        // The target is met soon after the load has come.
        let met = (300..900).find(|f| error(*f, all[*f as usize]) <= 0.02);
        assert!(met.is_some_and(|met| met < 400), "{name}: {met:?}");
    }
}

#[test]
fn noise_does_not_make_mixes_swing() {
    for (name, law, round, load) in LAWS {
        let levers = both(round);
        let noise = |frame: u32| (0.2 * f64::from(frame.wrapping_mul(2_654_435_761) >> 16) / 65_536.0).exp();
        let error = |frame, mix: Mix| noise(frame) * load * law(mix.substeps.into(), mix.rounds.into());
        let all = mixes(0.02, Mix { substeps: 8, rounds: 8 }, 7200, (&levers, 0.3), error);
        let changes = all[3600..].windows(2).filter(|w| w[0] != w[1]).count();
        let costs: f64 = all[3600..].iter().map(|mix| levers.cost(*mix)).sum::<f64>() / 3600.0;
        let (least, best) = cheapest(AIM * 0.02 / 0.2f64.exp(), &levers, |mix| error(0, mix) / noise(0));
        eprintln!("{:.3} {changes} {name}: {:?}, best {best:?}", costs / least, all[7199]);
        // A change per second would be one at every patience of four.
        assert!(changes <= 30, "{name}: {changes}");
        assert!(costs <= 1.2 * least, "{name}: {costs} {least}");
    }
}

#[test]
fn what_cannot_be_met_costs_no_more_than_with_substeps_alone() {
    for (round, start) in [(0.1, 0), (0.2, 8)] {
        let levers = Levers { start, ..both(round) };
        let all = mixes(0.01, Mix { substeps: 8, rounds: start }, 1200, (&levers, 1.0), |_, _| 1.0);
        let most = Mix { substeps: MAX_SUBSTEPS, rounds: start };
        assert!(all.iter().all(|mix| levers.cost(*mix) <= levers.cost(most)), "{:?}", all[1199]);
    }
}

#[test]
fn rounds_that_are_fixed_stay_and_fast_colliders_are_met() {
    let levers = Levers { fewest: 20, ..SUBSTEPS };
    let start = Mix { substeps: 8, rounds: 5 };
    let all = mixes(0.01, start, 600, (&levers, 1.0), |_, mix| 0.1 / f64::from(mix.substeps * mix.substeps));
    assert_eq!(all[599], Mix { substeps: 20, rounds: 5 });
    assert!(all.iter().all(|mix| mix.rounds == 5));
}

#[test]
fn a_budget_buys_the_better_mix() {
    // 30 ms, of which a substep takes 1 and a round 0.1; polish does more than it costs.
    let levers = both(0.1);
    let error = |mix: Mix| 500.0 / (f64::from(mix.substeps * mix.substeps) * f64::from(1 + mix.rounds));
    let run = |levers: &Levers| {
        let mut chooser = Chooser::default();
        let mut mix = Mix { substeps: 8, rounds: 0 };
        for _ in 0..1200 {
            mix = chooser.next(Quality::ErrorWithin { stretch: 0.01, ms: 30.0 }, mix, levers);
            chooser.measured(error(mix));
            chooser.stepped(FRAME);
            chooser.took(mix.substeps, 0.2 + levers.cost(mix));
        }
        mix
    };
    let (alone, mixed) = (run(&SUBSTEPS), run(&levers));
    assert!(levers.cost(mixed) <= 30.0 && levers.cost(mixed) > 24.0, "{mixed:?}");
    assert!(error(mixed) < 0.6 * error(alone), "{alone:?} {mixed:?}");
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

#[test]
fn a_chooser_with_the_numbers_of_another_goes_on_as_that_one() {
    let levers = both(0.4);
    let mut first = Chooser::default();
    let mut mix = Mix { substeps: 6, rounds: 2 };
    let step = |chooser: &mut Chooser, mix: &mut Mix, frame: u32| {
        *mix = chooser.next(Quality::Error(0.02), *mix, &levers);
        let wave = 1.0 + 0.1 * f64::from(frame % 7);
        chooser.measured(wave * 4.0 / f64::from(mix.substeps).powi(2) / f64::from(mix.rounds + 1));
        chooser.stepped(FRAME);
        *mix
    };
    (0..300).for_each(|frame| _ = step(&mut first, &mut mix, frame));
    let numbers = first.numbers();
    let mut second = Chooser::default();
    second.resume(&numbers);
    assert_eq!(second.numbers().map(f64::to_bits), numbers.map(f64::to_bits));
    let mut other = mix;
    for frame in 300..900 {
        assert_eq!(step(&mut first, &mut mix, frame), step(&mut second, &mut other, frame), "{frame}");
    }
    // Numbers that no chooser has are not taken over.
    for n in 0..NUMBERS {
        let mut spoilt = numbers;
        spoilt[n] = f64::NEG_INFINITY;
        second.resume(&spoilt);
        let known: Vec<f64> = second.numbers().into_iter().filter(|x| !x.is_nan()).collect();
        assert!(known.iter().all(|x| *x > f64::NEG_INFINITY), "{n}: {known:?}");
    }
}
