use super::*;

const WHOLE: WorkUnit = WorkUnit { pass: 0, first_pixel: 0, pixels: 2 };

fn piece(pass: u32, value: f32) -> Piece {
    let film = vec![Pixel { rgb: [value, 2.0 * value, 0.0], rays: 3, ..Pixel::default() }; 2];
    Piece::new(WorkUnit { pass, ..WHOLE }, &film, &[], 10)
}

fn of(values: &[f32]) -> ProgressState {
    let mut state = ProgressState::new([2, 1], 0.1, false);
    values.iter().zip(0..).for_each(|(&value, pass)| state.add(piece(pass, value)));
    state
}

#[test]
fn a_picture_is_the_mean_of_its_passes_and_its_variance_that_of_a_mean() {
    assert_eq!(of(&[]).image().rgb, [[0.0; 3]; 2]);
    let state = of(&[1.0, 2.0, 6.0]);
    assert_eq!(state.image().rgb, [[3.0, 6.0, 0.0]; 2]);
    // The passes scatter by s² = 7, over 3 passes.
    let variance = state.variance().unwrap();
    assert!((variance[0][0] - 7.0 / 3.0).abs() < 1e-12 && (variance[1][1] - 28.0 / 3.0).abs() < 1e-12);
    let noise = (7.0 / 3.0 / 9.01 + 28.0 / 3.0 / 36.01) / 3.0;
    assert!((state.noise().unwrap() - noise).abs() < 1e-12);
    assert_eq!((state.passes(), state.photons(), state.counts.rays), (3, 30, 18));
}

#[test]
fn one_pass_is_the_picture_and_has_no_variance() {
    let state = of(&[0.123_456_7]);
    assert_eq!(state.image().rgb[0], [0.123_456_7, 2.0 * 0.123_456_7, 0.0]);
    assert!(state.variance().is_none() && state.noise().is_none());
}

/// Values whose sum depends on the order in which f64 adds them.
fn values(count: u32) -> Vec<f32> {
    let random = |i: u32| pcg4d([i, 7, 0, 0]);
    (0..count).map(|i| random(i)[0] as f32 * 2f32.powi((random(i)[1] % 20) as i32 - 20)).collect()
}

#[test]
fn neither_the_order_of_arrival_nor_who_added_what_shows() {
    for count in [1, 2, 3, 7, 8, 21, 64] {
        let values = values(count);
        let expected = of(&values);
        assert_eq!(expected.nodes.len() as u32, count.count_ones());
        for seed in 0..5 {
            let mut order: Vec<u32> = (0..count).collect();
            order.sort_by_key(|&i| pcg4d([i, seed, 1, 0])[0]);
            let mut shuffled = ProgressState::new([2, 1], 0.1, false);
            order.iter().for_each(|&pass| shuffled.add(piece(pass, values[pass as usize])));
            assert!(shuffled == expected, "{count} passes, order {order:?}");
            // Each pass is computed by one of three, who send what they have in the end.
            let mut three = vec![ProgressState::new([2, 1], 0.1, false); 3];
            for &pass in &order {
                three[pcg4d([pass, seed, 2, 0])[0] as usize % 3].add(piece(pass, values[pass as usize]));
            }
            let mut merged = ProgressState::new([2, 1], 0.1, false);
            three.into_iter().for_each(|state| merged.absorb(state).unwrap());
            assert!(merged == expected, "{count} passes of three");
        }
    }
    // A sum in another order has other bits, so that this could have failed.
    let values = values(64);
    let square = |value: f32| f64::from(value) * f64::from(value);
    let differs = |count: usize| {
        let plain = values[..count].iter().fold(0.0, |sum, &value| sum + square(value));
        of(&values[..count]).total(|values| values.squares(0))[0] != plain
    };
    assert!((3..64).filter(|&count| differs(count)).count() > 5);
}

#[test]
fn a_pass_is_whole_when_its_last_tile_is_there() {
    let tile = |first_pixel: u32, value: f32| {
        let unit = WorkUnit { pass: 0, first_pixel, pixels: 1 };
        Piece::new(unit, &[Pixel { rgb: [value; 3], rays: 1, ..Pixel::default() }], &[], 10)
    };
    let mut state = ProgressState::new([2, 1], 0.1, false);
    state.add(tile(1, 5.0));
    assert_eq!((state.passes(), state.photons()), (0, 0));
    assert_eq!(state.image().rgb, [[0.0; 3], [5.0; 3]], "what there is of the first pass is shown");
    assert_eq!(state.missing(2), ["pass 1", "pixels 0 to 0 of pass 0"]);
    assert!(state.done().has(&tile(1, 5.0).unit) && !state.done().has(&tile(0, 0.0).unit));
    let mut other = ProgressState::new([2, 1], 0.1, false);
    other.add(tile(0, 4.0));
    assert_eq!(state.clone().absorb(state.clone()), Err(tile(1, 0.0).unit));
    other.absorb(state.clone()).unwrap();
    assert_eq!((other.passes(), other.photons(), other.counts.rays), (1, 10, 2));
    assert_eq!(other.image().rgb, [[4.0; 3], [5.0; 3]]);
    assert_eq!(other.absorb(state), Err(tile(1, 0.0).unit));
    assert_eq!(other.missing(1), [""; 0]);
}

#[test]
fn gaps_are_named_and_end_the_picture() {
    let mut state = of(&[1.0, 3.0]);
    state.add(piece(3, 100.0));
    state.add(piece(9, 100.0));
    assert_eq!(state.passes(), 2);
    assert_eq!(state.image().rgb[0][0], 2.0);
    assert_eq!(state.missing(11), ["pass 2", "passes 4 to 8", "pass 10"]);
    assert_eq!(state.missing(9), ["pass 2", "passes 4 to 8"]);
}

#[test]
fn radii_shrink_as_published_and_seeds_differ() {
    assert_eq!(pass_radius(0.1, 0, 0.5, 0.0), 0.1);
    // r₂² = r₁²·(1 + α)/2, r₃² = r₂²·(2 + α)/3.
    let third = 0.1 * (1.5f64 / 2.0 * 2.5 / 3.0).sqrt();
    assert!((f64::from(pass_radius(0.1, 2, 0.5, 0.0)) - third).abs() < 1e-8);
    // In the end as the power (α − 1)/2 of the passes.
    let slope = (pass_radius(1.0, 40_000, 2.0 / 3.0, 0.0) / pass_radius(1.0, 10_000, 2.0 / 3.0, 0.0)).ln() / 4f32.ln();
    assert!((slope + 1.0 / 6.0).abs() < 1e-3, "{slope}");
    assert_eq!(pass_radius(0.1, 1000, 0.01, 0.05), 0.05);
    let mut seeds: Vec<u32> = (0..1000).map(|pass| pass_seed(7, pass)).collect();
    assert_eq!(seeds[0], 7);
    seeds.sort_unstable();
    seeds.dedup();
    assert_eq!(seeds.len(), 1000);
}
