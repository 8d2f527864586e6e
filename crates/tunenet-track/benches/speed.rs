//! How fast a ball is followed: pictures in memory, and a video file, and decoding only.
//!
//! `cargo bench -p tunenet-track`

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use opencv::core::{CV_8UC3, Mat, Point, Scalar, Size};
use opencv::imgproc::{FILLED, LINE_AA, circle};
use opencv::videoio::{VideoWriter, VideoWriterTrait};
use tunenet_track::ball_colour::detect_ball;
use tunenet_track::track::Settings;
use tunenet_track::tracker::Tracker;
use tunenet_track::view::View;
use tunenet_track::{Source, track};

/// A red disc before a grey wall, on its way through the picture.
#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn picture(size: (i32, i32), radius: i32, frame: usize) -> Mat {
    let wall = Scalar::new(120.0, 125.0, 122.0, 0.0);
    let mut picture = Mat::new_rows_cols_with_default(size.1, size.0, CV_8UC3, wall).expect("a picture");
    let time_s = frame as f64 / 60.0;
    let u = 2.0 * f64::from(radius) + 0.3 * f64::from(size.0) * (0.9 * time_s).sin().abs();
    let v = f64::from(size.1) * (0.8 - 0.6 * (3.0 * time_s).cos().abs());
    let at = Point::new((16.0 * u) as i32, (16.0 * v) as i32);
    circle(&mut picture, at, 16 * radius, Scalar::new(40.0, 40.0, 220.0, 0.0), FILLED, LINE_AA, 4).expect("a disc");
    picture
}

fn small_pictures(criterion: &mut Criterion) {
    let pictures: Vec<Mat> = (0..400).map(|frame| picture((160, 120), 6, frame)).collect();
    let scene = detect_ball(&pictures[..48], None).expect("OpenCV").expect("a ball");
    let mut group = criterion.benchmark_group("track");
    group.throughput(Throughput::Elements(pictures.len() as u64));
    group.bench_function("160x120", |bencher| {
        bencher.iter(|| {
            let mut tracker = Tracker::new(scene.clone());
            let look = |picture| tracker.look(&View::of(picture).expect("a picture")).expect("OpenCV");
            let seen = pictures.iter().filter_map(look).count();
            assert_eq!(black_box(seen), pictures.len());
        });
    });
    group.finish();
}

fn write_video(path: &Path, frames: usize) {
    let codec = VideoWriter::fourcc('m', 'p', '4', 'v').expect("a codec");
    let name = path.to_str().expect("a name");
    let mut writer = VideoWriter::new(name, codec, 60.0, Size::new(1920, 1080), true).expect("a video");
    for frame in 0..frames {
        writer.write(&picture((1920, 1080), 40, frame)).expect("a frame");
    }
    writer.release().expect("a video");
}

fn full_videos(criterion: &mut Criterion) {
    const FRAMES: usize = 240;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("video.mp4");
    write_video(&path, FRAMES);
    let source = Source::new(&path, None);
    let mut group = criterion.benchmark_group("1080p");
    group.throughput(Throughput::Elements(FRAMES as u64)).sample_size(10);
    group.bench_function("decode", |bencher| {
        bencher.iter(|| {
            let streamed = source.stream(usize::MAX, &mut |_, _, image, _| Ok(vec![image])).expect("a video");
            assert_eq!(black_box(streamed).count, FRAMES);
        });
    });
    group.bench_function("decode and track", |bencher| {
        bencher.iter(|| black_box(track(&source, &Settings::default(), &mut |_, _| {}).expect("a video")));
    });
    group.finish();
}

criterion_group!(benches, small_pictures, full_videos);
criterion_main!(benches);
