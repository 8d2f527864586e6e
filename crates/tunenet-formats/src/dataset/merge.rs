//! Shards of a dataset, put together.

use std::path::{Path, PathBuf};

use tunenet_core::network::{DatasetHeader, Shard};

use super::file::{DatasetReader, DatasetWriter};
use super::message::ShardMessage;
use crate::{Error, Origin, Result};

/// Puts the shards of one dataset together into `out`: the bytes are those of the file that one run without shards writes.
///
/// Pairs go from file to file one by one. `progress` gets the number of pairs written and of all; an interrupted merge goes
/// on where it stopped.
///
/// # Errors
/// [`Error::File`] where a shard is missing, is there twice, belongs to another dataset or version, or was cut short;
/// otherwise as [`DatasetWriter`].
pub fn merge(shards: &[PathBuf], out: &Path, progress: &mut dyn FnMut(u64, u64) -> bool) -> Result<DatasetHeader> {
    let (header, ordered) = gather(shards)?;
    let mut writer = DatasetWriter::open(out, header.clone(), None)?;
    for (path, shard) in ordered {
        let there = writer.written();
        if shard.block(header.pairs).end <= there {
            continue;
        }
        let mut number = shard.block(header.pairs).start;
        for pair in DatasetReader::open_shard(path)? {
            let pair = pair?;
            if number >= there {
                writer.write(&pair)?;
            }
            number += 1;
            if number % 128 == 0 && !progress(number, header.pairs) {
                return Err(tunenet_core::Error::Stopped.into());
            }
        }
    }
    progress(header.pairs, header.pairs);
    writer.finish()?;
    Ok(header)
}

/// What all shards share, and the shards in their order.
fn gather(paths: &[PathBuf]) -> Result<(DatasetHeader, Vec<(&PathBuf, Shard)>)> {
    let mut known: Option<(&PathBuf, DatasetHeader, ShardMessage)> = None;
    let mut found: Vec<(&PathBuf, Shard)> = Vec::with_capacity(paths.len());
    for path in paths {
        let reader = DatasetReader::open_shard(path)?;
        let Some(message) = reader.shard_message() else { continue };
        let shard = message.shard(path)?;
        if let Some((first, header, like)) = &known {
            if let Some((expected, found)) = foreign((header, like), (reader.header(), message)) {
                let text = format!("expected a shard of {expected} as {}, found one of {found}", name(first));
                return Err(Error::file(path, text, "merge only shards of one `tunenet gen`"));
            }
        } else {
            let ours = env!("CARGO_PKG_VERSION");
            if message.version != ours {
                let text = format!("expected a shard by tunenet {ours}, found one by {}", message.version);
                return Err(Error::file(path, text, "merge with the version that wrote the shards"));
            }
            known = Some((path, reader.header().clone(), message.clone()));
        }
        if let Some((other, _)) = found.iter().find(|(_, known)| *known == shard) {
            let text = format!("expected every shard once, found {shard} here and in {}", name(other));
            return Err(Error::file(path, text, "leave one of them out"));
        }
        found.push((path, shard));
    }
    let Some((first, header, message)) = known else {
        return Err(tunenet_core::Error::Setting {
            origin: Origin::Flag,
            name: "SHARD",
            expected: "at least one shard".into(),
            found: "none".into(),
        }
        .into());
    };
    found.sort_by_key(|(_, shard)| *shard);
    let count = message.shard(first)?.count();
    let lacking: Vec<String> = (0..count)
        .filter(|index| found.binary_search_by_key(index, |(_, shard)| shard.index()).is_err())
        .map(|index| format!("{index}/{count}"))
        .collect();
    if !lacking.is_empty() {
        return Err(missing(first, count, &lacking));
    }
    Ok((header, found))
}

/// What is said where shards are missing next to `first`.
#[must_use]
pub fn missing(first: &Path, count: u32, lacking: &[String]) -> Error {
    const NAMED: usize = 8;
    let more = lacking.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let named = lacking[..lacking.len().min(NAMED)].join(", ");
    let text = format!("expected all {count} shards, found none that is {named}{more}");
    Error::file(first, text, "run the command that makes it again; it resumes")
}

/// The first thing in which a shard differs from the others, as it should be and as it is.
fn foreign(
    (header, message): (&DatasetHeader, &ShardMessage),
    (other, found): (&DatasetHeader, &ShardMessage),
) -> Option<(String, String)> {
    let seeds = (format!("seed {}", header.seed), format!("seed {}", other.seed));
    let pairs = (format!("{} pairs", header.pairs), format!("{} pairs", other.pairs));
    let presets = (format!("preset {}", header.preset), format!("preset {}", other.preset));
    let versions = (format!("tunenet {}", message.version), format!("tunenet {}", found.version));
    let counts = (format!("{} shards", message.count), format!("{} shards", found.count));
    let stated = [versions, presets, seeds, pairs, counts];
    let scenes = || ("the same scene".to_owned(), "another scene".to_owned());
    stated.into_iter().find(|(a, b)| a != b).or_else(|| (header != other).then(scenes))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
