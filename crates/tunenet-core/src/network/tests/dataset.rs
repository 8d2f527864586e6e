//! Datasets, whole, cut short and foreign.

use super::*;

#[test]
fn a_dataset_comes_back_as_it_was_written() {
    let folder = folder();
    let out = dataset(&folder, 20, 50);
    let reader = DatasetReader::open(&out).unwrap();
    assert_eq!(*reader.header(), header(20, 50));
    let pairs: Vec<Pair> = reader.map(Result::unwrap).collect();
    assert_eq!(pairs.len(), 20);
    for pair in &pairs {
        let again = rollout(&Bouncer::new(), &pair.target_parameters, &pair.own, &header(20, 50).clock).unwrap();
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
        pool.install(|| fill(&out, &header(150, 30))).unwrap();
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
        generate(&Bouncer::new(), &header(70, 40), &draw, &out, &mut progress).unwrap();
        assert!(std::fs::read(&out).unwrap() == whole, "cut at byte {cut}");
        assert!(cut < whole.len() / 2 || from >= 16, "cut at byte {cut} of {}: started from {from}", whole.len());
    }
}

#[test]
fn a_stopped_dataset_goes_on() {
    let folder = folder();
    let whole = std::fs::read(dataset(&folder, 300, 10)).unwrap();
    let out = folder.path().join("again.mcap");
    let stopped = generate(&Bouncer::new(), &header(300, 10), &draw, &out, &mut |done, _| done == 0);
    assert!(matches!(stopped, Err(Error::Stopped)));
    assert!(!out.exists());
    let mut first = None;
    let mut progress = |done, _| {
        first.get_or_insert(done);
        true
    };
    generate(&Bouncer::new(), &header(300, 10), &draw, &out, &mut progress).unwrap();
    assert_eq!(first, Some(128));
    assert!(std::fs::read(&out).unwrap() == whole);
}

#[test]
fn a_partial_of_something_else_is_refused() {
    let folder = folder();
    let out = folder.path().join("pairs.mcap");
    let partial = folder.path().join("pairs.mcap.partial");
    fill(&folder.path().join("other.mcap"), &DatasetHeader { seed: 2, ..header(20, 30) }).unwrap();
    std::fs::rename(folder.path().join("other.mcap"), &partial).unwrap();
    let refused = fill(&out, &header(20, 30)).unwrap_err();
    assert!(refused.to_string().contains("other settings"), "{refused}");
    assert!(refused.hint().unwrap().contains("--out"));
    std::fs::write(&partial, "a shopping list, and not a short one").unwrap();
    assert!(fill(&out, &header(20, 30)).unwrap_err().to_string().contains("another kind of file"));
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
        let roll = |e: &[f64]| rollout(&Bouncer::new(), e, &own, &clock);
        let (one, two) = (roll(&proposed)?, roll(&target)?);
        let (proposed_parameters, target_parameters) = (proposed, target);
        Ok(Pair { proposed: one, target: two, proposed_parameters, target_parameters, own, scale, clock })
    };
    super::super::fill(&header, &make, &out, &mut |_, _| true).unwrap();
    let pairs: Vec<Pair> = DatasetReader::open(&out).unwrap().collect::<Result<_>>().unwrap();
    assert!(pairs.iter().enumerate().all(|(i, pair)| pair.clock.len() == 30 + i && pair.target.len() == 3 * (30 + i)));
    let seed = header.seed;
    assert_eq!(pairs[7], make(7, &mut stream(seed, 7)).unwrap());
    // From the file or from memory, the network is the same.
    let options = options(short(40), None);
    let from_file = train(&out, &options, &mut |_| true).unwrap();
    let from_memory = train_on(&header, &pairs, &options, &mut |_| true).unwrap();
    assert!(from_file.from_recordings() && from_file.to_bytes().unwrap() == from_memory.to_bytes().unwrap());
    assert!(matches!(
        train(&out, &TrainOptions { preset: Preset::paper(), ..options }, &mut |_| true),
        Err(Error::File { .. })
    ));
}
