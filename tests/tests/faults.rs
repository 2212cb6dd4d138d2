//! Planted faults: each comparison that other tests rely on fails when the smallest thing is wrong.

use caustic_device::{Device, Plan};
use caustic_kernels::layout::{Arrival, Irradiance, Neighbour, Photon, Site};
use caustic_kernels::num::div;
use caustic_photon_map::{Gather, Hash, MapOptions, PhotonMap, RadixSort};
use caustic_tests::points::{photons_at, query, uniform};
use caustic_tests::{
    assert_same_words, compare_irradiance, compare_neighbours, compare_sorted, compare_words, oracle_irradiance,
    oracle_k_nearest, oracle_within,
};

const RADIUS: f32 = 0.3;
const K: usize = 20;

fn photons() -> Vec<Photon> {
    photons_at(1, &uniform(1, 1000, [0.0; 3], [1.0; 3]))
}

fn map(photons: &[Photon]) -> (Device, PhotonMap) {
    let cpu = Device::cpu();
    let options = MapOptions { radius: RADIUS, hash: Hash::Teschner, table: None, cell: None };
    let map = PhotonMap::build(&cpu, photons, &options).unwrap();
    (cpu, map)
}

#[test]
fn one_flipped_bit_in_any_word_is_seen() {
    let expected = photons();
    assert_eq!(compare_words("same", &expected, &expected), Ok(8 * expected.len()));
    for word in 0..8 {
        for bit in [0, 15, 31] {
            let mut actual = expected.clone();
            bytemuck::cast_slice_mut::<_, u32>(&mut actual)[8 * 777 + word] ^= 1 << bit;
            let text = compare_words("flipped", &expected, &actual).unwrap_err();
            assert!(text.contains("of 8000 words 1 differ"), "{text}");
            assert!(text.contains(&format!("record 777 word {word}")), "{text}");
        }
    }
}

#[test]
fn the_report_has_hexadecimal_decimal_and_ulp() {
    let text = compare_words("here", &[1.0f32, 2.0], &[1.0, 2.0f32.next_up().next_up()]).unwrap_err();
    assert_eq!(
        text,
        "here: of 2 words 1 differ and 0 are NaN; first: here record 1 word 0: expected 0x40000000, found 0x40000002 \
         (2e0 and 2.0000005e0, 2 ulp apart)"
    );
    let text = compare_words("there", &[1u32, 5, 7], &[1, 6, 8]).unwrap_err();
    assert_eq!(
        text,
        "there: of 3 words 2 differ and 0 are NaN; first: there record 1 word 0: expected 0x00000005, found 0x00000006"
    );
}

#[test]
fn the_sign_of_a_zero_is_seen() {
    assert!(compare_words("zeros", &[0.0f32], &[-0.0]).is_err());
    assert!(compare_words("zeros", &[0.0f32], &[0.0]).is_ok());
}

#[test]
fn a_nan_fails_even_against_itself() {
    for nan in [f32::NAN, -f32::NAN, f32::from_bits(0x7f80_0001)] {
        assert!(compare_words("NaN", &[nan], &[nan]).unwrap_err().contains("1 are NaN"));
        assert!(compare_words("NaN", &[1.0], &[nan]).is_err());
        assert!(compare_words("NaN", &[nan], &[1.0]).is_err());
        // In an integer word the same bits are a number like any other.
        assert!(compare_words("no float", &[nan.to_bits()], &[nan.to_bits()]).is_ok());
        let estimate = Irradiance { rgb: [0.0, nan, 0.0], photons: 1 };
        assert!(compare_irradiance("NaN", &[estimate], &[estimate]).is_err());
        let neighbour = vec![Neighbour { distance2: nan, photon: 0 }];
        assert!(compare_neighbours("NaN", std::slice::from_ref(&neighbour), std::slice::from_ref(&neighbour)).is_err());
    }
    let direction = Photon { direction: f32::NAN.to_bits(), ..Photon::default() };
    assert!(compare_words("a packed direction", &[direction], &[direction]).is_ok());
}

#[test]
fn a_missing_record_is_seen() {
    assert!(compare_words("short", &[1u32, 2], &[1]).is_err());
    assert!(compare_words("long", &[1u32], &[1, 2]).is_err());
    assert!(compare_words::<u32>("empty", &[], &[]).is_ok());
}

#[test]
#[should_panic(expected = "of 1 words 1 differ")]
fn the_assertion_panics() {
    assert_same_words("panic", &[1u32], &[2]);
}

#[test]
fn faults_of_a_sort_are_seen() {
    let cpu = Device::cpu();
    let keys: Vec<u32> = (0..5000u32).map(|i| i.wrapping_mul(0x9e37_79b9) >> 24).collect();
    let buffer = cpu.upload("keys", &keys).unwrap();
    let mut plan = Plan::new();
    let result = RadixSort::plan(&cpu, &mut plan, &buffer, 5000, 8).unwrap();
    cpu.run(&plan).unwrap();
    let sorted: Vec<u32> = cpu.read(&result.keys, 5000).unwrap();
    let order: Vec<u32> = cpu.read(&result.order, 5000).unwrap();
    assert_eq!(compare_sorted("right", &keys, &sorted, &order), Ok(10_000));

    // Two pairs of one key the other way round: sorted, but not stably.
    let at = (1..5000).find(|&i| sorted[i - 1] == sorted[i]).unwrap();
    let mut unstable = order.clone();
    unstable.swap(at - 1, at);
    assert!(compare_sorted("unstable", &keys, &sorted, &unstable).is_err());
    // Two different keys the other way round, with their indices.
    let at = (1..5000).find(|&i| sorted[i - 1] != sorted[i]).unwrap();
    let (mut swapped, mut with) = (sorted.clone(), order.clone());
    swapped.swap(at - 1, at);
    with.swap(at - 1, at);
    assert!(compare_sorted("not sorted", &keys, &swapped, &with).is_err());
    // One key in place of another, and an index twice.
    let mut wrong = sorted.clone();
    wrong[4999] ^= 1;
    assert!(compare_sorted("another key", &keys, &wrong, &order).is_err());
    let mut twice = order.clone();
    twice[1] = twice[0];
    assert!(compare_sorted("twice", &keys, &sorted, &twice).is_err());
    assert!(compare_sorted("short", &keys, &sorted[1..], &order[1..]).is_err());
}

#[test]
fn faults_of_neighbours_are_seen() {
    let photons = photons();
    let (cpu, map) = map(&photons);
    let point = [0.5, 0.4, 0.6];
    let expected = vec![oracle_k_nearest(&photons, point, K, RADIUS)];
    let right = map.k_nearest(&cpu, &[query(point)], K as u32, Gather::Heap).unwrap();
    assert_eq!(right[0].len(), K, "the query must find k photons for the faults below to mean something");
    assert_eq!(compare_neighbours("right", &expected, &right), Ok(2 * K));
    let with = |fault: &dyn Fn(&mut Vec<Neighbour>)| {
        let mut wrong = right.clone();
        fault(&mut wrong[0]);
        compare_neighbours("wrong", &expected, &wrong)
    };
    assert!(with(&|_| ()).is_ok());
    assert!(with(&|row| row.truncate(K - 1)).is_err(), "one lost at the end");
    assert!(with(&|row| row.rotate_left(1)).is_err(), "the first at the end");
    assert!(with(&|row| row.insert(3, row[3])).is_err(), "one counted twice");
    assert!(with(&|row| row[7].photon ^= 1).is_err(), "another photon");
    assert!(with(&|row| row[7].distance2 = row[7].distance2.next_up()).is_err(), "one ulp");
    assert!(with(&|row| row.swap(4, 5)).is_err(), "not in order");
    assert!(compare_neighbours("no query", &expected, &[]).is_err());

    // The (k + 1)-th in place of the k-th: what a bound that is off by one gives.
    let mut one_more = oracle_k_nearest(&photons, point, K + 1, RADIUS);
    one_more.remove(K - 1);
    assert!(compare_neighbours("the next", &expected, &[one_more]).is_err());
    // Ties by anything but the index.
    let same_place = photons_at(1, &[[0.1; 3]; 4]);
    let ties = oracle_k_nearest(&same_place, [0.1; 3], 2, 1.0);
    let other_ties = [Neighbour { distance2: 0.0, photon: 0 }, Neighbour { distance2: 0.0, photon: 2 }];
    assert!(compare_neighbours("ties", &[ties], &[other_ties.to_vec()]).is_err());
}

#[test]
fn a_photon_dropped_from_a_map_is_seen() {
    let photons = photons();
    let point = [0.5, 0.4, 0.6];
    let nearest = oracle_k_nearest(&photons, point, K, RADIUS);
    let expected = vec![nearest.clone()];
    let mut fewer = photons.clone();
    // Out of the map, but not out of the numbering.
    fewer[nearest[K / 2].photon as usize].position = [1.0; 3];
    let (cpu, map) = map(&fewer);
    let found = map.k_nearest(&cpu, &[query(point)], K as u32, Gather::List).unwrap();
    assert!(compare_neighbours("dropped", &expected, &found).is_err());
}

#[test]
fn faults_of_a_maps_buffers_are_seen() {
    let photons = photons();
    let (cpu, map) = map(&photons);
    let [sites, arrivals, begins] = map.buffers();
    let count = photons.len() as u64;
    let sites: Vec<Site> = cpu.read(sites, count).unwrap();
    let mut wrong = sites.clone();
    wrong.swap(10, 11);
    assert!(compare_words("sites", &sites, &wrong).is_err());
    let arrivals: Vec<Arrival> = cpu.read(arrivals, count).unwrap();
    let mut wrong = arrivals.clone();
    wrong.swap(10, 11);
    assert!(compare_words("arrivals", &arrivals, &wrong).is_err());
    let right: Vec<u32> = cpu.read(begins, u64::from(map.grid().table) + 1).unwrap();
    assert_eq!(compare_words("begins", &right, &right), Ok(right.len()));
    let mut wrong = right.clone();
    *wrong.last_mut().unwrap() ^= 1;
    assert!(compare_words("begins", &right, &wrong).is_err());
    let at = (1..right.len()).find(|&i| right[i - 1] != right[i]).unwrap();
    let mut wrong = right.clone();
    wrong.swap(at - 1, at);
    assert!(compare_words("begins", &right, &wrong).is_err());
}

#[test]
fn faults_of_an_estimate_are_seen() {
    let photons = photons();
    let (cpu, map) = map(&photons);
    let point = [0.5, 0.4, 0.6];
    let within = oracle_within(&photons, point, RADIUS);
    assert!(within.len() > K + 1);
    let expected = [oracle_irradiance(&photons, &within, K, RADIUS)];
    let right = map.irradiance(&cpu, &[query(point)], K as u32, Gather::Heap).unwrap();
    assert_eq!(compare_irradiance("right", &expected, &right), Ok(4));

    let mut wrong = right.clone();
    wrong[0].rgb[2] = wrong[0].rgb[2].next_down();
    assert!(compare_irradiance("one ulp", &expected, &wrong).is_err());
    let mut wrong = right.clone();
    wrong[0].photons -= 1;
    assert!(compare_irradiance("photons", &expected, &wrong).is_err());
    // A photon left out and the disc that reaches to the k-th photon.
    let mut lost = within.clone();
    lost.remove(K / 2);
    let wrong = [oracle_irradiance(&photons, &lost, K, RADIUS)];
    assert!(compare_irradiance("lost", &wrong, &right).is_err());
    let mut r_k = within.clone();
    r_k[K] = r_k[K - 1];
    let wrong = [oracle_irradiance(&photons, &r_k, K, RADIUS)];
    assert!(compare_irradiance("r_k", &wrong, &right).is_err());
    // Powers added up one after another, with a rounding each: these differ so much that it shows in the bits.
    let mut plain = right.clone();
    for channel in 0..3 {
        let power = |n: &Neighbour| photons[n.photon as usize].power[channel];
        plain[0].rgb[channel] = div(within[..K].iter().map(power).sum(), std::f32::consts::PI * within[K].distance2);
    }
    assert!(compare_irradiance("plain addition", &plain, &right).is_err());
    assert!((plain[0].rgb[0] / right[0].rgb[0] - 1.0).abs() < 1e-5, "only the rounding is another");
}
