//! The files that a simulation file names, as they are seen from another folder: the model of an arm or a robot, and the folder in which
//! a program runs.

use std::path::{Path, PathBuf};

use toml_edit::value;

use super::{SimulationFile, table};
use crate::scene::{Process, ProcessScene, Scene};

impl SimulationFile {
    /// The folder in which the program runs: that of the file, and what `process.folder` adds to it.
    #[must_use]
    pub fn program_folder(&self) -> PathBuf {
        let base = folder_of(self.path());
        let added = self.process().ok().and_then(|process| process.folder.as_ref());
        added.map_or_else(|| base.to_path_buf(), |folder| base.join(folder))
    }

    /// Rewrites the paths in a file that will be written to `out`, so that they lead to the same files from the folder of `out`. Does nothing
    /// to an absolute path, or where one of the folders does not exist.
    pub fn move_to(&mut self, out: &Path) {
        self.move_program(out);
        self.move_model(out);
    }

    fn move_program(&mut self, out: &Path) {
        let (Ok(runs), Ok(there)) = (self.program_folder().canonicalize(), folder_of(out).canonicalize()) else {
            return;
        };
        let Scene::Process(ProcessScene { process: Process { folder, .. }, .. }) = &mut self.scene else { return };
        let now = folder.clone().unwrap_or_else(|| ".".into());
        if now.is_absolute() {
            return;
        }
        let Some(seen) = relative(&runs, &there) else { return };
        if now == seen || now == Path::new(".") && seen.as_os_str().is_empty() {
            return;
        }
        let process = table(self.document.root_mut(), "process", false);
        if seen.as_os_str().is_empty() {
            process.remove("folder");
            *folder = None;
        } else {
            process["folder"] = value(seen.to_string_lossy().into_owned());
            *folder = Some(seen);
        }
    }

    fn move_model(&mut self, out: &Path) {
        let base = folder_of(&self.path).to_path_buf();
        let (key, model) = match &mut self.scene {
            Scene::Arm(scene) => ("arm.urdf", &mut scene.arm.urdf),
            Scene::Robot(scene) => ("robot.model", &mut scene.robot.model),
            Scene::Ball(_) | Scene::Process(_) | Scene::Equations(_) => return,
        };
        let (Ok(from), Ok(to)) = (base.canonicalize(), folder_of(out).canonicalize()) else { return };
        if model.is_absolute() || from == to {
            return;
        }
        if let Some(seen) = seen_from(out, &base.join(&*model)) {
            self.document.set_text(key, &seen.to_string_lossy());
            *model = seen;
        }
    }
}

/// The path of `file` from the folder in which `out` lies or will lie; `None` where one of the two folders does not exist or they
/// have no root in common. A link is named, not what it leads to.
#[must_use]
pub fn seen_from(out: &Path, file: &Path) -> Option<PathBuf> {
    let (to, from) = (folder_of(file).canonicalize().ok()?, folder_of(out).canonicalize().ok()?);
    Some(relative(&to, &from)?.join(file.file_name()?))
}

/// The folder in which a file lies.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// `to` as seen from `from`, both absolute; `None` where they have no root in common.
fn relative(to: &Path, from: &Path) -> Option<PathBuf> {
    let (ours, theirs): (Vec<_>, Vec<_>) = (to.components().collect(), from.components().collect());
    let common = ours.iter().zip(&theirs).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Path::new("..").as_os_str(), theirs.len() - common);
    (common > 0).then(|| up.chain(ours[common..].iter().map(|c| c.as_os_str())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_named_from_another() {
        let seen = |to: &str, from: &str| relative(Path::new(to), Path::new(from)).unwrap();
        assert_eq!(seen("/a/b", "/a/b"), Path::new(""));
        assert_eq!(seen("/a/b", "/a/c/d"), Path::new("../../b"));
        assert_eq!(seen("/a/b", "/"), Path::new("a/b"));
    }

    const ROBOT: &str = "kind = \"robot\"\n\n[inputs.goal_rad]\n[joints.elbow]\ndrive = \"position\"\ncommand = \"goal_rad\"\n\
        observe = [\"elbow_rad\"]\nkp = 1.0\ngain_1_rad = 3.2\n\n[robot]\nmodel =  \"arm.xml\"  # of the lab\n\
        [parameters.elbow__stall_torque]\nvalue = 3.0\nmin = 0.1\nmax = 9.0\n";

    /// A file that is written to another folder leads to the same model, and nothing else in it changes.
    #[test]
    fn a_model_is_named_from_the_folder_of_the_file_that_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let in_folder = |path: &str| folder.path().join(path);
        for name in ["models", "results/deep"] {
            std::fs::create_dir_all(in_folder(name)).unwrap();
        }
        let of = |text: &str| SimulationFile::parse(&in_folder("models/robot.toml"), text).unwrap();
        let moved = |text: &str, out: &str| {
            let mut file = of(text);
            file.move_to(&in_folder(out));
            // What the scene says is what the text says.
            assert_eq!(SimulationFile::parse(file.path(), &file.text()).unwrap(), file);
            file.text()
        };
        assert_eq!(moved(ROBOT, "results/a.toml"), ROBOT.replace("arm.xml", "../models/arm.xml"));
        assert_eq!(moved(ROBOT, "results/deep/a.toml"), ROBOT.replace("arm.xml", "../../models/arm.xml"));
        assert_eq!(moved(ROBOT, "models/a.toml"), ROBOT);
        assert_eq!(moved(ROBOT, "nowhere/a.toml"), ROBOT);
        let below = ROBOT.replace("arm.xml", "../results/deep/arm.xml");
        assert_eq!(moved(&below, "results/a.toml"), ROBOT.replace("arm.xml", "deep/arm.xml"));
        let absolute = ROBOT.replace("arm.xml", "/lab/arm.xml");
        assert_eq!(moved(&absolute, "results/a.toml"), absolute);
    }
}
