//! Datasets, whole, cut short and foreign.

use std::path::{Path, PathBuf};

use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use tunenet_core::network::{DatasetHeader, Pair, PairDraw, Shard, stream};
use tunenet_core::simulator::rollout;

use super::*;
use crate::{Error, Result};
use tunenet_core::testing::reflected_point::{ReflectedPoint, draw, header, scale};

fn filled(out: &Path, header: &DatasetHeader) -> Result<()> {
    generate(&ReflectedPoint::new(), header, None, &draw, out, &mut |_, _| true)
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn dataset(folder: &tempfile::TempDir, pairs: u64, samples: u32) -> PathBuf {
    let out = folder.path().join("pairs.mcap");
    filled(&out, &header(pairs, samples)).unwrap();
    out
}

#[test]
fn a_dataset_comes_back_as_it_was_written() {
    let folder = folder();
    let out = dataset(&folder, 20, 50);
    let reader = DatasetReader::open(&out).unwrap();
    assert_eq!(*reader.header(), header(20, 50));
    let pairs: Vec<Pair> = reader.map(Result::unwrap).collect();
    assert_eq!(pairs.len(), 20);
    for pair in &pairs {
        let again = rollout(&ReflectedPoint::new(), &pair.target_parameters, &pair.own, &header(20, 50).clock).unwrap();
        assert_eq!(pair.target, again);
        assert_eq!(pair.scale, Some(scale(pair.own[0])));
    }
    assert!(!folder.path().join("pairs.mcap.partial").exists());
}

#[test]
fn threads_do_not_change_the_bytes() {
    let folder = folder();
    let bytes = [1, 3].map(|threads| {
        let out = folder.path().join(format!("{threads}.mcap"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| filled(&out, &header(150, 30))).unwrap();
        std::fs::read(out).unwrap()
    });
    assert_eq!(bytes[0], bytes[1]);
}

#[test]
fn an_interrupted_dataset_goes_on_to_the_same_bytes() {
    let folder = folder();
    let whole = std::fs::read(dataset(&folder, 70, 40)).unwrap();
    let out = folder.path().join("again.mcap");
    let partial = folder.path().join("again.mcap.partial");
    let mut random = <ChaCha8Rng as rand::SeedableRng>::seed_from_u64(3);
    let mut cuts = vec![0, 5, 100, whole.len() / 2, whole.len() - 1, whole.len()];
    cuts.extend((0..20).map(|_| random.random_range(0..whole.len())));
    for cut in cuts {
        std::fs::write(&partial, &whole[..cut]).unwrap();
        let mut from = u64::MAX;
        let mut progress = |done, _| {
            from = from.min(done);
            true
        };
        generate(&ReflectedPoint::new(), &header(70, 40), None, &draw, &out, &mut progress).unwrap();
        assert!(std::fs::read(&out).unwrap() == whole, "cut at byte {cut}");
        assert!(cut < whole.len() / 2 || from >= 16, "cut at byte {cut} of {}: started from {from}", whole.len());
    }
}

#[test]
fn a_stopped_dataset_goes_on() {
    let folder = folder();
    let whole = std::fs::read(dataset(&folder, 300, 10)).unwrap();
    let out = folder.path().join("again.mcap");
    let stopped = generate(&ReflectedPoint::new(), &header(300, 10), None, &draw, &out, &mut |done, _| done == 0);
    assert!(matches!(stopped, Err(Error::Core(tunenet_core::Error::Stopped))));
    assert!(!out.exists());
    let mut first = None;
    let mut progress = |done, _| {
        first.get_or_insert(done);
        true
    };
    generate(&ReflectedPoint::new(), &header(300, 10), None, &draw, &out, &mut progress).unwrap();
    assert_eq!(first, Some(128));
    assert!(std::fs::read(&out).unwrap() == whole);
}

#[test]
fn a_partial_of_something_else_is_refused() {
    let folder = folder();
    let out = folder.path().join("pairs.mcap");
    let partial = folder.path().join("pairs.mcap.partial");
    filled(&folder.path().join("other.mcap"), &DatasetHeader { seed: 2, ..header(20, 30) }).unwrap();
    std::fs::rename(folder.path().join("other.mcap"), &partial).unwrap();
    let refused = filled(&out, &header(20, 30)).unwrap_err();
    assert!(refused.to_string().contains("other settings"), "{refused}");
    assert!(refused.hint().unwrap().contains("--out"));
    std::fs::write(&partial, "a shopping list, and not a short one").unwrap();
    assert!(filled(&out, &header(20, 30)).unwrap_err().to_string().contains("another kind of file"));
}

#[test]
fn what_is_no_dataset_is_refused_in_one_sentence() {
    let folder = folder();
    let out = dataset(&folder, 40, 40);
    let bytes = std::fs::read(&out).unwrap();
    let refusal = |bytes: &[u8]| {
        let path = folder.path().join("bad.mcap");
        std::fs::write(&path, bytes).unwrap();
        let all = DatasetReader::open(&path).and_then(Iterator::collect::<Result<Vec<_>>>);
        let text = all.unwrap_err().to_string();
        assert!(!text.contains('\n'));
        text
    };
    assert!(refusal(b"t_s,z_m\n0,1\n").contains("expected an MCAP file"));
    assert!(refusal(&bytes[..bytes.len() / 2]).contains("cut short"));
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 0xff;
    assert!(refusal(&damaged).contains("expected"));
    assert!(matches!(DatasetReader::open(folder.path().join("none.mcap")), Err(Error::Io { .. })));
}

#[test]
fn pairs_with_clocks_of_their_own_come_back() {
    let folder = folder();
    let out = folder.path().join("pairs.mcap");
    let header = DatasetHeader { clock: Vec::new(), ..header(40, 0) };
    let make = |number: u64, random: &mut ChaCha8Rng| {
        let clock: Vec<f64> = (0..30 + number).map(|i| i as f64 / 20.0).collect();
        let PairDraw { proposed, target, own, scale } = draw(number, random);
        let roll = |e: &[f64]| rollout(&ReflectedPoint::new(), e, &own, &clock);
        let (one, two) = (roll(&proposed)?, roll(&target)?);
        let (proposed_parameters, target_parameters) = (proposed, target);
        Ok(Pair { proposed: one, target: two, proposed_parameters, target_parameters, own, scale, clock })
    };
    super::fill(&header, None, &make, &out, &mut |_, _| true).unwrap();
    let pairs: Vec<Pair> = DatasetReader::open(&out).unwrap().collect::<Result<_>>().unwrap();
    assert!(pairs.iter().enumerate().all(|(i, pair)| pair.clock.len() == 30 + i && pair.target.len() == 3 * (30 + i)));
    assert_eq!(pairs[7], make(7, &mut stream(header.seed, 7)).unwrap());
}

#[test]
fn merged_shards_are_the_whole_file() {
    let folder = folder();
    let whole = std::fs::read(dataset(&folder, 150, 30)).unwrap();
    for count in [1, 3, 4] {
        let shards: Vec<PathBuf> =
            (0..count).rev().map(|index| shard(&folder, &header(150, 30), index, count)).collect();
        let out = folder.path().join("merged.mcap");
        merge(&shards, &out, &mut |_, _| true).unwrap();
        assert!(std::fs::read(&out).unwrap() == whole, "{count} shards");
        // A merge that was killed resumes.
        std::fs::rename(&out, folder.path().join("merged.mcap.partial")).unwrap();
        let partial = std::fs::read(folder.path().join("merged.mcap.partial")).unwrap();
        std::fs::write(folder.path().join("merged.mcap.partial"), &partial[..partial.len() / 2]).unwrap();
        merge(&shards, &out, &mut |_, _| true).unwrap();
        assert!(std::fs::read(&out).unwrap() == whole, "{count} shards");
    }
}

fn shard(folder: &tempfile::TempDir, header: &DatasetHeader, index: u32, count: u32) -> PathBuf {
    let shard = Shard::new(index, count).unwrap();
    let out = folder.path().join(format!("{}-{index}-of-{count}.mcap", header.seed));
    generate(&ReflectedPoint::new(), header, Some(shard), &draw, &out, &mut |_, _| true).unwrap();
    out
}

#[test]
fn shards_that_do_not_belong_together_are_refused_by_name() {
    let folder = folder();
    let make = |header: &DatasetHeader, index, count| shard(&folder, header, index, count);
    let ours = header(60, 30);
    let all: Vec<PathBuf> = (0..3).map(|index| make(&ours, index, 3)).collect();
    let refusal = |shards: &[&PathBuf]| {
        let shards: Vec<PathBuf> = shards.iter().map(|p| (*p).clone()).collect();
        let out = folder.path().join("merged.mcap");
        let text = merge(&shards, &out, &mut |_, _| true).unwrap_err().to_string();
        assert!(!text.contains('\n') && !out.exists(), "{text}");
        text
    };
    assert!(refusal(&[&all[0], &all[2]]).ends_with("expected all 3 shards, found none that is 1/3"));
    let doubled = folder.path().join("copy.mcap");
    std::fs::copy(&all[1], &doubled).unwrap();
    let text = refusal(&[&all[0], &all[1], &all[2], &doubled]);
    assert!(text.contains("copy.mcap: expected every shard once, found 1/3 here and in 1-1-of-3.mcap"), "{text}");
    for (other, expected) in [
        (make(&DatasetHeader { seed: 2, ..ours.clone() }, 1, 3), "seed 1 as 1-0-of-3.mcap, found one of seed 2"),
        (make(&DatasetHeader { seed: 3, preset: "hard".into(), ..ours.clone() }, 1, 3), "found one of preset hard"),
        (make(&DatasetHeader { seed: 4, pairs: 61, ..ours.clone() }, 1, 3), "found one of seed 4"),
        (make(&ours, 1, 4), "3 shards as 1-0-of-3.mcap, found one of 4 shards"),
    ] {
        let text = refusal(&[&all[0], &other, &all[2]]);
        assert!(text.contains(expected), "{text}");
    }
    let bytes = std::fs::read(&all[1]).unwrap();
    std::fs::write(&all[1], &bytes[..bytes.len() / 2]).unwrap();
    assert!(refusal(&[&all[0], &all[1], &all[2]]).contains("1-1-of-3.mcap: expected a complete MCAP file"));
    assert!(!DatasetReader::holds(&all[1], &ours, Shard::new(1, 3).unwrap()));
    assert!(DatasetReader::holds(&all[2], &ours, Shard::new(2, 3).unwrap()));
    // A shard is no dataset, and a dataset no shard.
    let text = DatasetReader::open(&all[0]).err().unwrap().to_string();
    assert!(text.ends_with("expected a whole dataset, found shard 0/3"), "{text}");
    let whole = dataset(&folder, 20, 30);
    assert!(refusal(&[&all[0], &whole]).ends_with("expected a shard of a dataset, found a whole one"));
}

#[test]
fn shards_of_another_version_are_refused() {
    use super::message::{
        DATASET_DEFINITION, DATASET_TOPIC, HeaderMessage, SHARD_DEFINITION, SHARD_TOPIC, ShardMessage,
    };
    let folder = folder();
    let other = folder.path().join("other.mcap");
    let mut output = super::stream::Output::create(&other).unwrap();
    let shard = output.topic(SHARD_TOPIC, "tunenet_msgs/msg/Shard", SHARD_DEFINITION).unwrap();
    let dataset = output.topic(DATASET_TOPIC, "tunenet_msgs/msg/Dataset", DATASET_DEFINITION).unwrap();
    let message = ShardMessage { version: "0.0.1".into(), ..ShardMessage::new(Shard::new(1, 2).unwrap()) };
    output.write(shard, 0, &message).unwrap();
    output.write(dataset, 0, &HeaderMessage::from(&header(20, 30))).unwrap();
    output.finish().unwrap();
    let ours = shard_of(&folder);
    let refusal = |shards: &[&PathBuf]| {
        let shards: Vec<PathBuf> = shards.iter().map(|p| (*p).clone()).collect();
        merge(&shards, &folder.path().join("merged.mcap"), &mut |_, _| true).unwrap_err().to_string()
    };
    let version = env!("CARGO_PKG_VERSION");
    let first = refusal(&[&other, &ours]);
    assert!(first.ends_with(&format!("expected a shard by tunenet {version}, found one by 0.0.1")), "{first}");
    let second = refusal(&[&ours, &other]);
    assert!(second.ends_with("found one of tunenet 0.0.1"), "{second}");
    // A shard that was begun by another version is not resumed.
    assert!(!DatasetReader::holds(&other, &header(20, 30), Shard::new(1, 2).unwrap()));
}

fn shard_of(folder: &tempfile::TempDir) -> PathBuf {
    shard(folder, &header(20, 30), 0, 2)
}
