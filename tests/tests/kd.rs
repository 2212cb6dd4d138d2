//! The kd-tree: its structure on sets of all kinds, the same bytes on every device, and what its histograms are off by.

use caustic_device::{Device, LaneOrder};
use caustic_kernels::layout::{Photon, Site};
use caustic_kernels::rivals::kd::{
    KD_DEPTH, KD_LEAF, KD_MAX_PHOTONS, KD_MEDIAN_LEVELS, KD_SMALL, KdInner, coordinate, kd_quads,
};
use caustic_photon_map::MapError;
use caustic_rivals::{KD_HISTOGRAMS, KdSearch, KdTree, Photons, k_nearest, radius_error};
use caustic_tests::maps::limits_loops;
use caustic_tests::points::{clustered, photons_at, query, sets, uniform};
use caustic_tests::{compare_neighbours, compare_words, gpu, oracle_k_nearest};

const RADIUS: f32 = 0.2;

fn build(device: &Device, photons: &[Photon]) -> (Vec<Site>, KdTree) {
    let photons = Photons::upload(device, photons).unwrap();
    let tree = KdTree::build(device, &photons, RADIUS, KdSearch::Nearest).unwrap();
    (device.read(tree.quads(), u64::from(kd_quads(photons.count))).unwrap(), tree)
}

/// A subtree as it was walked.
struct Subtree {
    photons: Vec<u32>,
    depth: u32,
}

fn claim(holds: bool, what: &str, place: u32) -> Result<(), String> {
    if holds { Ok(()) } else { Err(format!("{what} at {place}")) }
}

/// Holds the subtree at a reference against the photons.
fn walk(tree: &[Site], photons: &[Photon], reference: u32, level: u32) -> Result<Subtree, String> {
    let place = reference & !KD_LEAF;
    claim((place as usize) < tree.len(), "a reference out of the tree", place)?;
    if reference & KD_LEAF != 0 {
        let site = tree[place as usize];
        let given = photons.get(site.photon() as usize).ok_or(format!("no such photon at {place}"))?.position;
        claim(given.map(f32::to_bits) == site.position().map(f32::to_bits), "another position", place)?;
        return Ok(Subtree { photons: vec![site.photon()], depth: 0 });
    }
    let node = KdInner::read(tree, place);
    claim(node.left & !KD_LEAF == place + 2, "the left child is not next", place)?;
    let left = walk(tree, photons, node.left, level + 1)?;
    let right_place = place + 2 + kd_quads(left.photons.len() as u32);
    claim(node.right & !KD_LEAF == right_place, "the right child is not after the left one", place)?;
    let right = walk(tree, photons, node.right, level + 1)?;
    let all = [left.photons.as_slice(), &right.photons].concat();
    let along = |photon: &u32, axis: usize| coordinate(photons[*photon as usize].position[axis]);
    for axis in 0..3 {
        let low = all.iter().map(|photon| along(photon, axis)).fold(f32::MAX, f32::min);
        let high = all.iter().map(|photon| along(photon, axis)).fold(f32::MIN, f32::max);
        claim(node.low[axis].to_bits() == low.to_bits(), "a box that begins elsewhere", place)?;
        claim(node.high[axis].to_bits() == high.to_bits(), "a box that ends elsewhere", place)?;
    }
    let axis = node.axis as usize;
    claim(left.photons.iter().all(|photon| along(photon, axis) <= node.plane), "left of the plane", place)?;
    claim(right.photons.iter().all(|photon| along(photon, axis) >= node.plane), "right of the plane", place)?;
    if all.len() as u32 > KD_SMALL {
        let by_rank = left.photons.len() == all.len() / 2;
        let is_point = (0..3).all(|axis| node.low[axis] == node.high[axis]);
        let separated = left.photons.iter().all(|photon| along(photon, axis) < node.plane);
        let fits = if is_point || level >= KD_MEDIAN_LEVELS { by_rank } else { separated };
        claim(fits, "a large node that is not split as it should be", place)?;
    }
    Ok(Subtree { photons: all, depth: 1 + left.depth.max(right.depth) })
}

/// Holds a tree against the photons; returns the inner nodes above a photon at the most.
fn check(tree: &[Site], photons: &[Photon]) -> Result<u32, String> {
    if photons.is_empty() {
        return if tree.is_empty() { Ok(0) } else { Err("a tree of nothing".to_string()) };
    }
    let root = if photons.len() == 1 { KD_LEAF } else { 0 };
    let Subtree { photons: mut found, depth } = walk(tree, photons, root, 0)?;
    found.sort_unstable();
    claim(found.iter().copied().eq(0..photons.len() as u32), "not every photon once", 0)?;
    claim(depth <= KD_DEPTH, "deeper than the stack", depth)?;
    Ok(depth)
}

/// Crowds so narrow and far apart that spatial medians take many levels: each separates a photon.
fn deep() -> Vec<[f32; 3]> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    (0..50).flat_map(|i| axes.map(|axis| axis.map(|x: f32| x * 0.3f32.powi(i)))).collect()
}

/// Two crowds at the ends of a large box, their photons 10⁻³⁰ m to 1 m apart.
fn two_crowds() -> Vec<[f32; 3]> {
    let near = (0..100).map(|i| [10f32.powi(-(i % 31)), 0.0, 1e-30 * i as f32]);
    let far = (0..100).map(|i| [1e6 + i as f32, -1e6, 1e6 - (i % 3) as f32]);
    near.chain(far).collect()
}

fn degenerate() -> Vec<(String, Vec<Photon>)> {
    let mut all: Vec<(String, Vec<[f32; 3]>)> = vec![
        ("all in one point".into(), vec![[0.5, -0.5, 0.0]; 100]),
        ("two points".into(), (0..100).map(|i| [(i % 2) as f32, 3.0, 3.0]).collect()),
        (
            "two neighbouring floats".into(),
            (0..100).map(|i| if i % 3 == 0 { [1.0; 3] } else { [1.0f32.next_up(); 3] }).collect(),
        ),
        ("collinear".into(), (0..200).map(|i| [i as f32, 2.0 * i as f32, -1.0]).collect()),
        ("collinear, aslant and in reverse".into(), (0..200).map(|i| [1.0 - i as f32 * 0.01; 3]).collect()),
        ("two crowds".into(), two_crowds()),
        ("deep".into(), deep()),
        (
            "the ends of all floats".into(),
            (0..100).map(|i| [f32::MAX, f32::MIN, 0.0].map(|x| if i % 3 == 0 { x } else { -x })).collect(),
        ),
        ("clustered".into(), clustered(5, 2000)),
    ];
    for n in [0, 1, 2, 3, 31, 32, 33, 64, 65, 66, 1000] {
        all.push((format!("{n} evenly spread"), uniform(n, n, [-1.0; 3], [1.0; 3])));
    }
    let given = all.into_iter().map(|(name, points)| (name, photons_at(3, &points)));
    given.chain(sets(300).into_iter().map(|set| (set.name.to_string(), set.photons))).collect()
}

#[test]
fn every_tree_has_every_photon_once_on_the_right_side_of_every_plane() {
    for (name, photons) in degenerate() {
        let (tree, index) = build(&Device::cpu(), &photons);
        let depth = check(&tree, &photons).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        assert!(index.levels()[0] + index.levels()[1] >= depth, "{name}: levels {:?}, depth {depth}", index.levels());
    }
    // 32 levels give up a photon each, the two after them half of what is left: 118, 59, 30 and 29.
    let deep = photons_at(3, &deep());
    assert_eq!(build(&Device::cpu(), &deep).1.levels()[0], KD_MEDIAN_LEVELS + 2);
}

#[test]
fn trees_are_the_same_on_all_devices_byte_for_byte() {
    for (name, photons) in degenerate() {
        let (expected, _) = build(&Device::cpu(), &photons);
        let cpus = [LaneOrder::Reversed, LaneOrder::Shuffled(1)].map(Device::cpu_with_order);
        for device in cpus.iter().chain(gpu()) {
            let stage = format!("{name} on {}", device.name());
            compare_words(&stage, &expected, &build(device, &photons).0).unwrap();
        }
    }
}

#[test]
fn searches_at_all_depths_are_exact() {
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        for points in [deep(), two_crowds(), vec![[1.0; 3]; 100], uniform(4, 33, [0.0; 3], [1.0; 3])] {
            let given = photons_at(1, &points);
            let photons = Photons::upload(device, &given).unwrap();
            let queries: Vec<_> = points.iter().step_by(3).map(|&point| query(point)).collect();
            for (search, radius) in [(KdSearch::Nearest, 1e7), (KdSearch::Range, 1e7), (KdSearch::Range, 1e-3)] {
                let tree = KdTree::build(device, &photons, radius, search).unwrap();
                let expected: Vec<_> =
                    queries.iter().map(|query| oracle_k_nearest(&given, query.position, 20, radius)).collect();
                let found = k_nearest(device, &tree, &queries, 20).unwrap();
                compare_neighbours(&format!("{search:?} on {}", device.name()), &expected, &found).unwrap();
            }
        }
    }
}

/// Every claim about a tree fails when the smallest thing is wrong with it.
#[test]
fn faults_in_a_tree_are_seen() {
    let photons = photons_at(1, &uniform(1, 500, [0.0; 3], [1.0; 3]));
    let (tree, _) = build(&Device::cpu(), &photons);
    check(&tree, &photons).unwrap();
    let fault = |place: usize, change: &dyn Fn(Site) -> Site| {
        let mut faulty = tree.clone();
        faulty[place] = change(faulty[place]);
        check(&faulty, &photons).expect_err("a fault that is not seen")
    };
    let bits = |site: Site, word: u32, bit: u32| {
        let mut position = site.position();
        position[word as usize] = f32::from_bits(position[word as usize].to_bits() ^ bit);
        Site::new(position, site.photon())
    };
    let link = |site: Site, flip: u32| Site::new(site.position(), site.photon() ^ flip);
    assert_eq!(fault(0, &|site| bits(site, 1, 1)), "a box that begins elsewhere at 0");
    assert_eq!(fault(1, &|site| bits(site, 2, 1)), "a box that ends elsewhere at 0");
    assert_eq!(fault(0, &|site| link(site, 1)), "the right child is not after the left one at 0");
    // The plane a quarter of its value lower or higher.
    assert!(fault(1, &|site| link(site, 1 << 23)).contains("of the plane at 0"));
    // A photon's index, and its position.
    let leaf = tree.len() - 1;
    assert!(fault(leaf, &|site| link(site, 1)).starts_with("another position"));
    assert!(fault(leaf, &|site| bits(site, 0, 1)).starts_with("another position"));
    let first = tree[leaf - 1];
    assert!(fault(leaf, &|_| first).starts_with("a box") || fault(leaf, &|_| first).contains("plane"));
    // A photon twice, where no box shows it.
    let one_point = vec![photons[0]; 40];
    let (mut tree, _) = build(&Device::cpu(), &one_point);
    *tree.last_mut().unwrap() = Site::new(one_point[0].position, 3);
    assert_eq!(check(&tree, &one_point), Err("not every photon once at 0".to_string()));
}

#[test]
fn histograms_leave_less_than_a_tenth_of_a_percent_of_the_first_radius() {
    for device in [Some(&Device::cpu()), gpu()].into_iter().flatten() {
        let n = if limits_loops(device) { 800 } else { 20_000 };
        let photons = Photons::upload(device, &photons_at(1, &uniform(1, n, [0.0; 3], [1.0; 3]))).unwrap();
        let tree = KdTree::build(device, &photons, RADIUS, KdSearch::Range).unwrap();
        let queries: Vec<_> = uniform(2, 100, [0.2; 3], [0.8; 3]).into_iter().map(query).collect();
        let mut last = f64::MAX;
        for (iterations, shell) in [(0, 1.0), (1, 1.0 / 32.0), (KD_HISTOGRAMS, 1.0 / 1024.0), (3, 1.0 / 32768.0)] {
            let error = radius_error(device, &tree, &queries, 10, iterations).unwrap();
            assert_eq!(error.queries, 100);
            assert!(error.max_of_first <= shell * 1.001 && error.mean >= 0.0, "{iterations}: {error:?}");
            assert!(error.mean < last / 8.0 && error.mean <= error.max, "{iterations}: {error:?}");
            last = error.mean;
        }
        // Nobody has that many: there is nothing to compare.
        assert_eq!(radius_error(device, &tree, &queries[..3], 1000, 2).unwrap().queries, 0);
    }
}

#[test]
fn radii_and_numbers_that_a_tree_cannot_have_are_refused() {
    let cpu = Device::cpu();
    let mut photons = Photons::upload(&cpu, &photons_at(1, &[[0.0; 3]])).unwrap();
    for radius in [0.0, -1.0, 1e-10, 2e18, f32::NAN] {
        let refused = KdTree::build(&cpu, &photons, radius, KdSearch::Nearest).err();
        assert!(matches!(refused, Some(MapError::Radius { .. })), "{radius}");
    }
    photons.count = KD_MAX_PHOTONS + 1;
    let refused = KdTree::build(&cpu, &photons, 1.0, KdSearch::Nearest).err();
    assert!(matches!(refused, Some(MapError::TooMany { max: KD_MAX_PHOTONS, .. })));
}
