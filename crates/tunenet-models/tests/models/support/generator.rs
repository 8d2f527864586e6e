//! Robots that nobody has: MJCF texts drawn from a seed, with every notation that the reader takes on.

use std::fmt::Write;

/// A stream of draws (Steele, Lea and Flood 2014, `SplitMix64`).
pub struct Draw(pub u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number between these.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of so many.
    pub fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % count as u64).expect("below a usize")
    }

    fn chance(&mut self, of: f64) -> bool {
        self.between(0.0, 1.0) < of
    }

    fn vector(&mut self, size: f64) -> String {
        format!("{} {} {}", self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }
}

/// What a robot is drawn with.
pub struct Robot {
    draw: Draw,
    degrees: bool,
    joints: Vec<String>,
    bodies: usize,
    body_text: String,
}

const CLASSES: [&str; 4] = ["main", "arm", "wrist", "tool"];

/// The text of a robot.
pub fn mjcf(seed: u64) -> String {
    let mut draw = Draw(seed);
    let degrees = draw.chance(0.5);
    let euler = ["xyz", "zyx", "XYZ", "zXy", "xzX"][draw.below(5)];
    let mut compiler =
        format!("<compiler angle=\"{}\" eulerseq=\"{euler}\"", if degrees { "degree" } else { "radian" });
    for (chance, text) in [
        (0.2, " balanceinertia=\"true\""),
        (0.2, " boundmass=\"0.3\" boundinertia=\"0.002\""),
        (0.2, " settotalmass=\"7\""),
        (0.15, " inertiafromgeom=\"true\""),
    ] {
        if draw.chance(chance) {
            compiler += text;
        }
    }
    let mut robot = Robot { draw, degrees, joints: Vec::new(), bodies: 0, body_text: String::new() };
    let trees = 1 + robot.draw.below(2);
    for _ in 0..trees {
        robot.body(2);
    }
    let defaults = robot.defaults();
    let actuators = robot.actuators();
    let gravity = robot.draw.vector(9.0);
    format!(
        "<mujoco model=\"drawn {seed}\">\n{compiler}/>\n<option gravity=\"{gravity}\"/>\n{defaults}<worldbody>\n{}</worldbody>\n{actuators}</mujoco>\n",
        robot.body_text
    )
}

impl Robot {
    fn angle(&mut self, from: f64, to: f64) -> f64 {
        let angle = self.draw.between(from, to);
        if self.degrees { angle.to_degrees() } else { angle }
    }

    fn turn(&mut self) -> String {
        match self.draw.below(6) {
            0 => String::new(),
            1 => format!(" quat=\"{} {}\"", self.draw.between(-1.0, 1.0), self.draw.vector(1.0)),
            2 => {
                let axis = self.draw.vector(1.0);
                format!(" axisangle=\"{axis} {}\"", self.angle(-3.0, 3.0))
            }
            3 => {
                let [a, b, c] = [self.angle(-3.0, 3.0), self.angle(-1.5, 1.5), self.angle(-3.0, 3.0)];
                format!(" euler=\"{a} {b} {c}\"")
            }
            4 => format!(" xyaxes=\"{} {}\"", self.draw.vector(1.0), self.draw.vector(1.0)),
            _ => format!(" zaxis=\"{}\"", self.draw.vector(1.0)),
        }
    }

    fn defaults(&mut self) -> String {
        let mut joint = || {
            let mut text = String::from("<joint");
            for key in ["damping", "armature", "frictionloss", "stiffness"] {
                if self.draw.chance(0.4) {
                    let _ = write!(text, " {key}=\"{}\"", self.draw.between(0.0, 2.0));
                }
            }
            text + "/>"
        };
        let (a, b, c) = (joint(), joint(), joint());
        let kp = self.draw.between(1.0, 100.0);
        format!(
            "<default>{a}<geom density=\"500\"/>\n <default class=\"arm\">\n  <default class=\"wrist\">{b}<position kp=\"{kp}\" forcerange=\"-3 3\"/>\
             <default class=\"tool\">{c}<position dampratio=\"0.7\" inheritrange=\"0.9\"/></default></default>\n\
             <geom type=\"capsule\" size=\"0.03 0.1\"/><motor gear=\"3\" ctrlrange=\"-1 2\"/></default>\n</default>\n"
        )
    }

    fn body(&mut self, depth: usize) {
        let name = format!("body{}", self.bodies);
        self.bodies += 1;
        let (place, turn) = (self.draw.vector(0.5), self.turn());
        let class = CLASSES[self.draw.below(4)];
        let class =
            if self.draw.chance(0.4) && class != "main" { format!(" childclass=\"{class}\"") } else { String::new() };
        let framed = self.draw.chance(0.2);
        if framed {
            let (place, turn) = (self.draw.vector(0.3), self.turn());
            let _ = writeln!(self.body_text, "<frame pos=\"{place}\"{turn}>");
        }
        let _ = writeln!(self.body_text, "<body name=\"{name}\" pos=\"{place}\"{turn}{class}>");
        for _ in 0..=self.draw.below(2) {
            let joint = self.joint();
            self.body_text += &joint;
        }
        let weight = self.weight();
        self.body_text += &weight;
        for _ in 0..self.draw.below(3) {
            if depth > 0 {
                self.body(depth - 1);
            }
        }
        self.body_text += if framed { "</body></frame>\n" } else { "</body>\n" };
    }

    fn joint(&mut self) -> String {
        let name = format!("joint{}", self.joints.len());
        self.joints.push(name.clone());
        let slide = self.draw.chance(0.25);
        let mut text =
            format!("<joint name=\"{name}\" pos=\"{}\" axis=\"{}\"", self.draw.vector(0.2), self.draw.vector(1.0));
        let mut number = |robot: &mut Self, key: &str, from: f64, to: f64| {
            if robot.draw.chance(0.4) {
                let value = if slide { robot.draw.between(from, to) } else { robot.angle(from, to) };
                let _ = write!(text, " {key}=\"{value}\"");
            }
        };
        number(self, "ref", -1.0, 1.0);
        number(self, "springref", -1.0, 1.0);
        if self.draw.chance(0.7) {
            let (lower, upper) = (self.draw.between(-3.0, -0.1), self.draw.between(0.1, 3.0));
            let scale = if slide || !self.degrees { 1.0 } else { 1f64.to_degrees() };
            let _ = write!(text, " range=\"{} {}\"", lower * scale, upper * scale);
        }
        if slide {
            text += " type=\"slide\"";
        }
        if self.draw.chance(0.3) {
            let _ = write!(text, " class=\"{}\"", CLASSES[self.draw.below(4)]);
        }
        for key in ["damping", "armature", "frictionloss", "stiffness"] {
            if self.draw.chance(0.3) {
                let _ = write!(text, " {key}=\"{}\"", self.draw.between(0.0, 2.0));
            }
        }
        text + "/>\n"
    }

    fn weight(&mut self) -> String {
        let (place, mass) = (self.draw.vector(0.1), self.draw.between(0.1, 3.0));
        // Moments of three points of mass are those of a body.
        let squares: Vec<f64> = (0..3).map(|_| self.draw.between(0.001, 0.02) * mass).collect();
        let moments = format!("{} {} {}", squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]);
        let shape = self.shape();
        match self.draw.below(4) {
            0 => {
                format!("<inertial pos=\"{place}\"{} mass=\"{mass}\" diaginertia=\"{moments}\"/>{shape}\n", self.turn())
            }
            1 => {
                let [a, b, c] = [0, 1, 2].map(|_| self.draw.between(-1e-4, 1e-4));
                format!("<inertial pos=\"{place}\" mass=\"{mass}\" fullinertia=\"{moments} {a} {b} {c}\"/>{shape}\n")
            }
            2 => shape + "\n",
            _ => {
                let turn = self.turn();
                format!("{shape}<frame pos=\"{place}\"{turn}>{}</frame>\n", self.shape())
            }
        }
    }

    fn shape(&mut self) -> String {
        let kind = ["sphere", "capsule", "cylinder", "box", "ellipsoid"][self.draw.below(5)];
        let [a, b, c] = [0, 1, 2].map(|_| self.draw.between(0.02, 0.2));
        let weight = match self.draw.below(3) {
            0 => format!(" mass=\"{}\"", self.draw.between(0.1, 2.0)),
            1 => format!(" density=\"{}\"", self.draw.between(100.0, 3000.0)),
            _ => String::new(),
        };
        if kind != "sphere" && self.draw.chance(0.3) {
            let (from, to) = (self.draw.vector(0.3), self.draw.vector(0.3));
            return format!("<geom type=\"{kind}\" size=\"{a}\" fromto=\"{from} {to}\"{weight}/>");
        }
        let (place, turn) = (self.draw.vector(0.2), self.turn());
        format!("<geom type=\"{kind}\" size=\"{a} {b} {c}\" pos=\"{place}\"{turn}{weight}/>")
    }

    fn actuators(&mut self) -> String {
        let mut text = String::from("<actuator>\n");
        for joint in self.joints.clone() {
            let number = self.draw.between(0.5, 50.0);
            let kind = match self.draw.below(9) {
                0 => format!("<motor joint=\"{joint}\" class=\"arm\"/>"),
                1 => format!("<position joint=\"{joint}\" kp=\"{number}\" kv=\"1.5\" ctrlrange=\"-1 1\"/>"),
                2 => format!("<position joint=\"{joint}\" kp=\"{number}\" dampratio=\"1.1\"/>"),
                3 => format!("<position joint=\"{joint}\" class=\"wrist\" kv=\"0.2\" timeconst=\"0.05\"/>"),
                4 => format!("<velocity joint=\"{joint}\" kv=\"{number}\" class=\"wrist\" gear=\"2.5\"/>"),
                5 => format!(
                    "<general joint=\"{joint}\" gainprm=\"{number}\" biastype=\"affine\" biasprm=\"0.1 -{number} -0.3\" forcerange=\"-9 9\"/>"
                ),
                6 => format!("<general joint=\"{joint}\" gainprm=\"{number}\" dyntype=\"filter\" dynprm=\"0.03\"/>"),
                7 => format!("<intvelocity joint=\"{joint}\" kp=\"{number}\" kv=\"0.5\"/>"),
                _ => format!(
                    "<position joint=\"{joint}\" gear=\"{}\" class=\"wrist\" delay=\"0.02\" nsample=\"20\"/>",
                    0.5 + number
                ),
            };
            text += &kind;
            text.push('\n');
        }
        text + "</actuator>\n"
    }
}
