//! Files whose equations are wrong: one sentence, with line and column.

use crate::common::Folder;

#[test]
fn a_mistake_is_shown_at_its_character() {
    let folder = Folder::new();
    folder.run("init equations").ends(0);
    let good = folder.text("equations.toml");
    for (from, to, wanted) in [
        ("sin(angle_rad)", "sin(angle)", "found `angle`"),
        ("sin(angle_rad)", "sin(angle_rad", "or `)`, found the end"),
        ("angle_rad = \"rate_rad_s\"", "angle_rad = \"length\"", "a formula in 1/s, found one in m"),
        ("[start.rate_rad_s]\nvalue = 0.0\n", "", "expected [start.rate_rad_s]"),
        ("gravity = 9.81", "pi = 9.81", "no constant of mathematics, found `pi`"),
        ("[constants]", "[constant]", "found `constant`"),
    ] {
        assert!(good.contains(from), "{from}");
        folder.write("wrong.toml", good.replacen(from, to, 1));
        for command in ["simulate --sim wrong.toml --out swing.csv", "inspect wrong.toml"] {
            let ran = folder.run(command).ends(1);
            let text = format!("{}{}", ran.stdout, ran.stderr);
            assert!(text.contains(wanted) && text.contains("wrong.toml:"), "{command}: {text}");
        }
    }
    let refused = folder.run("simulate --sim equations.toml --set constants.gravitas=1 --out swing.csv").ends(2);
    assert!(refused.stderr.contains("a constant of the file (gravity, gain)"), "{}", refused.stderr);
}
