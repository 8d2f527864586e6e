#!/usr/bin/env bash
# Makes the seed corpora again, from assets/ and with the tool: `cargo build` comes first.
set -euo pipefail
cd "$(dirname "$0")/.."
tool=$PWD/${CARGO_TARGET_DIR:-target}/debug/tunenet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
rm -rf fuzz/corpus; mkdir -p fuzz/corpus/{csv,mcap,bag,parquet,lerobot,calibration,hdf5,npz,simulation,task,model,robot}
seed() { # TARGET NAME [FIRST-BYTE]: what comes in, behind the byte that says how it is read
    { [[ -z ${3-} ]] || printf '%b' "$3"; cat; } > "fuzz/corpus/$1/$2"
}

bare() { sed 's/[ ]*#.*//; /^$/d' "$1"; } # comments only make seeds long

head -12 assets/observations/drop.csv | seed csv drop '\x00'
head -12 assets/observations/bounces.csv | seed csv bounces '\x00'
head -6 assets/observations/drop.csv | cut -d, -f1,4 | sed '1s/.*/time,height/' | seed csv columns '\x01'
printf 'time,q1,q2,effort_0,effort_1\n0,0.1,0.2,3,4\n10,0.11,0.21,3.1,4.1\n20,0.12,0.22,3.2,4.2\n' | seed csv joints_by_column '\x02'
printf 't_s;z_cm\n0;100,5\n0,01;x\n0,02;99,8\n0,03;99,2\n\n' | seed csv semicolons '\x03'
printf 't_s,q1_rad,q2_rad,dq1_rad_s,dq2_rad_s,tau1_nm,tau2_nm\n0,.1,.2,0,0,1,2\n.01,.11,.2,0,0,1,2\n.02,.12,.2,0,0,1,2\n' \
    | seed csv joints '\x04'
printf '\xef\xbb\xbf# a note\r\nt_ms\tx_mm\ty_mm\tz_mm\r\n0\t1e3\t-0\tnan\r\n1\t1\t2\t3\r\n' | seed csv tabs '\x00'
printf 'bounce_number,bounce_time_s\n1,0.5\n2,1.1\n4,1.9\n' | seed csv numbered '\x00'
printf 't_s,u_px,v_px\n0,10,20\n.033,10,25\n.066,10,33\n' | seed csv pixels '\x00'

for name in ball ball_easy ball_hard table_tennis arm; do bare "assets/$name.toml" | seed simulation "$name"; done
{ bare assets/ball.toml; printf '\0effects.quadratic_drag.c_1_m=0.13'; } | seed simulation set
"$tool" init ball --out "$folder/all.toml" 2> /dev/null && sed 's/^# *\([a-z_0-9]* = \|\[\)/\1/' "$folder/all.toml" > "$folder/keys.toml" && bare "$folder/keys.toml" | seed simulation all_keys
printf '{"elbow": {"id": 1, "drive_mode": 0, "homing_offset": -12, "range_min": 1000, "range_max": 3048}}' | seed calibration joints
printf '{"motor_names": ["a", "b"], "calib_mode": ["DEGREE", "LINEAR"], "start_pos": [1, 2], "end_pos": [3, 40]}' | seed calibration lists
seed task shot < assets/shot.toml
sed 's/^radius_m.*/&\nrim_radius_m = 0.002\ntilt_about_x_rad = 0.1\ntilt_about_y_rad = 0/;
    s/^heights_m.*/&\nposition_sd_m = 0.001\nvelocity_sd_m_s = 0.01/; s/^link.*/&\ngrip_m = [0, 0, 0.1]\nbase_rpy_rad = [0, 0, 1]/' \
    assets/shot.toml | seed task all_keys

"$tool" simulate --sim assets/ball.toml --set release.height_m=1 --set record.frames=5 --out "$folder/a.mcap" 2> /dev/null
seed mcap simulated '\x00' < "$folder/a.mcap"
"$tool" gen ball --sim assets/ball_easy.toml --set record.frames=12 --set record.rate_hz=8 --pairs 12 --out "$folder/pairs.mcap" 2> /dev/null
seed mcap pairs '\x00' < "$folder/pairs.mcap"
seed robot mjcf << 'END'
<mujoco model="a"><compiler angle="degree" eulerseq="zyx" boundmass="0.01"/><option gravity="0 0 -9" timestep="0.001"/>
<default><joint damping="1"/><default class="x"><position kp="3" dampratio="1" inheritrange="0.9"/><geom type="box" size=".1 .1 .2"/></default></default>
<worldbody><body name="b" childclass="x"><frame euler="1 2 3"><joint name="j" axis="0 1 1" range="-90 90" ref="3"/><geom fromto="0 0 0 0 0 1"/></frame>
<body pos="1 0 0" quat="1 0 0 1"><inertial pos="0 0 0" mass="1" fullinertia="1 1 1 0 0 0"/><joint name="k" type="slide" damping="1 2"/><joint name="l"/></body></body></worldbody>
<equality><joint joint1="j" joint2="l" polycoef="0 2"/></equality><tendon><fixed name="t"><joint joint="j" coef=".5"/></fixed></tendon>
<actuator><position class="x" joint="j" kp="5" forcerange="-1 1"/><motor joint="k" gear="2"/><general tendon="t" biastype="affine" biasprm="0 -1 -2"/></actuator></mujoco>
END
seed robot free << 'END'
<mujoco><worldbody><body><freejoint/><geom size=".1"/><body zaxis="0 1 0"><joint type="ball" damping=".1"/><geom type="capsule" size=".1 .2" mass="2"/>
<body axisangle="1 0 0 90"><joint/><geom type="mesh" mesh="m"/></body></body></body></worldbody><asset><mesh name="m" file="m.stl"/></asset></mujoco>
END
seed robot urdf << 'END'
<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="0 0 1" rpy="1 2 3"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="c"/><joint name="j" type="revolute"><origin xyz="0 0 1"/><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="3" velocity="1"/><dynamics damping="1"/></joint>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/><mimic joint="j" multiplier="2"/></joint>
<transmission name="t"><joint name="j"/><actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>
<ros2_control name="s" type="system"><joint name="k"><command_interface name="effort"><param name="min">-1</param><param name="max">1</param></command_interface></joint></ros2_control></robot>
END
python3 fuzz/make_messages.py fuzz/corpus/mcap
python3 fuzz/make_bags.py fuzz/corpus/bag
python3 fuzz/make_parquet.py fuzz/corpus # needs the Python package pyarrow
python3 fuzz/make_arrays.py fuzz/corpus # needs the Python packages h5py and numpy
"$tool" train --data "$folder/pairs.mcap" --preset paper --out "$folder/m.safetensors" 2> /dev/null
seed model paper < "$folder/m.safetensors"
git checkout --quiet -- fuzz/corpus/mcap/{promises_much,chunk_overrun,short_attachment} fuzz/corpus/npz/foreign_letter # found, not made
du -sh fuzz/corpus/*
