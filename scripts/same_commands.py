# SPDX-License-Identifier: MIT
"""The commands that scripts/same_as compares, as jobs: lists of commands that use the files of those before them.

Paths begin with the links of a job: opencv (photographs of Debian's package opencv-doc), real (ALIDADE_REAL_DATA),
testdata and config. The sets of checkerboards are those of scripts/real_data.
"""
import importlib.machinery
import importlib.util
import math
import os
import random

PROGRAM_COMMANDS = ["calibrate", "detect", "rig calibrate", "rig validate", "rig rectify", "rig triangulate", "project",
                    "unproject", "pose", "undistort", "validate", "diff", "fleet", "convert", "formats", "report",
                    "track", "board", "simulate", "handeye calibrate",
                    "handeye validate", "help"]
MODELS = ["pinhole", "radtan", "rational", "thin_prism", "kannala_brandt", "fov", "ucm", "omni", "eucm", "double_sphere"]
FORMATS = ["alidade", "opencv", "ros", "kalibr", "colmap", "colmap_rig", "mrcal", "basalt", "nerfstudio", "camodocal",
           "orbslam", "matlab"]
BOARDS = ["checkerboard:9x6:25mm", "charuco:8x11:24mm:18mm:DICT_4X4_1000", "aprilgrid:6x6:30mm:0.3",
          "circles:10x8:25mm:15mm", "acircles:4x11:20mm:14mm"]
CHARUCO = "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000"
SLEAP = "charuco:8x11:24mm:18.75mm:DICT_4X4_1000"
# name, inputs below ALIDADE_REAL_DATA, board; checkerboards are in scripts/real_data
OTHER_SETS = [
    ("sony circles", "sony_circles/regular", "circles:10x8:25mm:15mm"),
    ("sony hexagonal", "sony_circles/hexagonal", "circles:10x8:25mm:15mm"),
    *[("charuco " + name, "photonvision_charuco/lifecam/" + name, CHARUCO)
      for name in ("2024-05-07_lifecam_1280", "2024-05-07_lifecam_480", "2024-06-19_lifecam_1280_Old_Pattern",
                   "2024-06-19_lifecam_480_Old_Pattern")],
    *[("sleap " + name, f"sleap_anipose_4cam_charuco/{name}/calibration_images", SLEAP)
      for name in ("back", "mid", "side", "top")],
    ("webcam video", "webcams_charuco/calibration/intrinsic/cam_0.mp4", "charuco:4x5:54mm:40.5mm:DICT_4X4_1000"),
    ("aprilgrid", "aprilgrid_singles/EuRoC.png", "aprilgrid:6x6:88mm:0.3"),
]
# name, pictures below ALIDADE_REAL_DATA/footage, model, size, parameters
FOOTAGE = [
    ("chair", "boofcv_chair/image*.jpg", "radtan", "640x480", "477.1153682877197 478.4056498615274 317.3166700073147 "
     "241.06065005426453 0.01748195441951721 0.045233434344806055 0 0 0"),
    ("desk stills", "tum_fr2_desk_stills/ch12/*", "radtan", "640x480", "520.9 521.0 325.1 249.7 0.2312 -0.7849 -0.0033 "
     "-0.0001 0.9172"),
    ("wall", "boofcv_sony_wall_jar/mono_wall_*.jpg", "radtan", "640x480", "701.0116882676376 698.6537946928421 "
     "308.4551818095542 246.84300560315452 -0.25559248570886445 0.09997127476560613 0 0 0"),
    ("desk", "tum_fr1_desk/tum_fr1_desk_crf8.mp4", "radtan", "640x480", "517.3 516.5 318.6 255.3 0.2624 -0.9531 -0.0054 "
     "0.0026 1.1633"),
    ("highway", "udacity_highway/test_video.mp4", "radtan", "1280x720", "1159 1155 670 388 -0.2577 0.0453 -0.0007 0.0002 "
     "-0.1145"),
    ("gopro", "gopro_max_stabilised/max-heromode_video_only.mp4", "kannala_brandt", "848x480", "368.665 368.457 424.48 "
     "239.055 0.0646075465207674 0.039139647556618896 -0.041373671856156674 0.014898789517094136"),
    ("berlin", "opensfm_berlin/*.jpg", "pinhole", "3264x2448", "3076.9728 3076.9728 1631.5 1223.5"),
]
LENS_NAMES = {"pinhole": "", "radtan": "k1 k2 p1 p2 k3", "rational": "k1 k2 p1 p2 k3 k4 k5 k6",
              "thin_prism": "k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4", "kannala_brandt": "k1 k2 k3 k4", "fov": "w", "ucm": "alpha",
              "omni": "xi k1 k2 p1 p2", "eucm": "alpha beta", "double_sphere": "xi alpha"}
# Ranges that the parameters of simulated lenses are drawn from.
LENS_RANGES = {"radtan": {"k1": (-0.3, 0.05), "k2": (0, 0.1), "k3": (-0.02, 0.01)},
               "rational": {"k1": (0.1, 0.3), "k2": (0, 0.05), "k4": (0.3, 0.5), "k5": (0, 0.1)},
               "thin_prism": {"k1": (0.1, 0.3), "k2": (0, 0.05), "k4": (0.3, 0.5), "s1": (-1e-3, 1e-3), "s3": (-1e-3, 1e-3)},
               "kannala_brandt": {"k1": (-0.02, 0.02), "k2": (-0.01, 0.01), "k3": (-2e-3, 2e-3), "k4": (-5e-4, 5e-4)},
               "fov": {"w": (0.8, 1.0)}, "ucm": {"alpha": (0.45, 0.65)},
               "omni": {"xi": (0.8, 1.3), "k1": (-0.1, 0.02), "k2": (-0.02, 0.02)},
               "eucm": {"alpha": (0.5, 0.65), "beta": (0.8, 1.2)}, "double_sphere": {"xi": (-0.2, 0.2), "alpha": (0.5, 0.62)}}


QUICK_SETS = [0, 1, 2, 3, 6, 8, 9, 17]  # simulated sets: a rig, footage, a fleet, and every board


class Job:
    def __init__(self, name, lines, texts=None):
        self.name = "".join(c if c.isalnum() or c in "._-" else "_" for c in name)
        self.lines = lines
        self.texts = texts or {}
        self.links = {}


def real_data_sets(root):
    path = os.path.join(root, "scripts", "real_data")
    loader = importlib.machinery.SourceFileLoader("real_data", path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("real_data", loader))
    loader.exec_module(module)
    return module.OPENCV, module.SETS


def camera_map(model, size, values):
    """Returns a camera as a YAML map on one line, as a scene file takes it and as it is the rest of a camera file."""
    width, height = size.split("x")
    names = ["fx", "fy", "cx", "cy", *LENS_NAMES[model].split()]
    pairs = ", ".join(f"{name}: {value}" for name, value in zip(names, values, strict=True))
    return f"{{model: {model}, image_size: {{width: {width}, height: {height}}}, parameters: {{{pairs}}}}}"


def camera_text(model, size, values):
    return "alidade_camera: 1\n" + camera_map(model, size, values)[1:-1].replace(", image_size", "\nimage_size").replace(
        ", parameters", "\nparameters").replace("model", "model", 1) + "\n"


def drawn_camera(rng, model, width, height):
    names = LENS_NAMES[model].split()
    ranges = LENS_RANGES.get(model, {})
    lens = [rng.uniform(*ranges.get(name, (-1e-3, 1e-3))) for name in names]
    is_wide = model in MODELS[4:]
    scale = width * (rng.uniform(0.4, 0.55) if is_wide else rng.uniform(0.75, 1.2))  # pixels per radian on the axis
    if model in ("omni", "double_sphere"):
        scale *= 1 + lens[0]
    if model == "fov":
        scale *= lens[0] / (2 * math.tan(lens[0] / 2))
    ratio = rng.uniform(0.998, 1.002)
    values = [scale, scale * ratio, width / 2 + rng.uniform(-9, 9), height / 2 + rng.uniform(-9, 9), *lens]
    return camera_map(model, f"{width}x{height}", [float(f"{value:.6g}") for value in values])


def printed_jobs():
    specs = [*BOARDS, "config/boards/charuco_8x11_24mm.yaml"]
    return [Job("printed", [*[f"board {spec} -o board{i}.{end} --json" for i, spec in enumerate(specs) for end in ("pdf", "svg")],
                            "board charuco:8x11:24mm:18mm:DICT_4X4_1000 -o charuco.png --dpi 100",
                            "board checkerboard:9x6:25mm -o large.pdf --paper A3", "board checkerboard:9x6:25mm -o small.png --dpi 72",
                            "board checkerboard:30x20:40mm -o pages.pdf --paper A4", "board nonsense:9x6 -o none.pdf"])]


def help_jobs():
    lines = ["--help", "--version", "help", "nonsense", "", "help nonsense", "rig", "rig --help"]
    for command in PROGRAM_COMMANDS:
        lines += [command + " --help", "help " + command, command, command + " --bord", command + " --json nothing"]
    return [Job("help", lines)]


def calibrate_variants(quick):
    """The flags of calibrate, each at least once, for corners of one set; and the models in the formats of other tools."""
    fixed = "--model radtan" if quick else ""  # choosing a model takes most of the time
    variants = ["--json", "", f"--verbose {fixed}", "--quiet " + fixed, "--same-focal " + fixed, "--tolerance 5px " + fixed,
                "--distance 2m " + fixed, "--target-sigma 0.1px " + fixed, "--board-shape flat", "--board-shape warp " + fixed,
                "--board-shape uneven " + fixed, "--pupil 1 " + fixed, "--correction 4x3 " + fixed, "--name front --serial 17 --date 2026-05-06 " + fixed, "--model radtan --fix cx,cy,k3",
                "--model radtan --init start.yaml --fix k1", "--next-view next.svg " + fixed, "--config config/calibrate.yaml --jobs 2",
                "--model auto --fix cx,cy --json", "--model rational --to opencv --quiet -o - ", "--model nonsense", "--fix k9 " + fixed]
    lines = [f"calibrate corners.csv --model {model} --keep-untrustworthy -o {model}.yaml" for model in MODELS]
    lines.append("convert radtan.yaml -o start.yaml")
    for i, flags in enumerate(variants):
        output = "" if " -o " in flags else f"-o v{i}.yaml"
        lines.append(f"calibrate corners.csv {flags} --evidence e{i}.json --report page{i}.html {output}")
    for name in FORMATS:
        if not quick or name in ("kalibr", "matlab"):
            lines += [f"calibrate corners.csv --to {name} -o {name}.out --keep-untrustworthy", f"validate {name}.out --image-size 640x480"]
    for model in ("radtan", "kannala_brandt", "omni") if quick else MODELS:
        for name in FORMATS:
            lines += [f"convert {model}.yaml -o {model}_{name}.out --to {name}", f"convert {model}_{name}.out -o - --image-size 640x480"]
    return lines


def use_of_camera(camera, images, others):
    """Commands that read a camera file and images of its board. `others`: files to compare it with."""
    lines = [f"validate {camera} --verbose", f"validate {camera} --json --strict --junit junit.xml",
             f"validate {camera} --images corners.csv --report validation.html --verbose",
             f"validate {camera} --images corners.csv --json",
             f"project {camera} points.csv", f"project {camera} points.csv --jacobian --json",
             f"project {camera} points.csv --poses testdata/checkerboard/poses.yaml --clip",
             f"project {camera} --pose '{{quaternion_xyzw: [0, 0, 0.1, 0.995], translation_m: [0.1, 0, 1]}}' < points.csv",
             *[f"pose testdata/checkerboard/poses.yaml --to {form}" for form in ("euler_zyx_deg", "matrix", "csv", "kitti")],
             "pose testdata/checkerboard/poses.yaml --mean --json --invert",
             f"unproject {camera} pixels.csv", f"unproject {camera} pixels.csv --jacobian --json --clip"]
    for other in others:
        lines += [f"diff {camera} {other} -o diff.svg", f"diff {camera} {other} --json --distance 2m --grid 20x15",
                  f"diff {camera} {other} --same-frame --tolerance 0.5", f"validate {camera} --against {other} --json"]
    for i, flags in enumerate(["--resize 320x240", "--crop 10,20,400,300", "--bin 2", "--rotate 90", "--rotate 180",
                               "--resize 320x240 --rotate 270 --crop 100,100,300,200"]):
        lines.append(f"convert {camera} -o edited{i}.yaml {flags}")
    lines += [f"convert {camera} -o as_{model}.yaml --model {model} --max-error 5 --json" for model in MODELS]
    lines += [f"convert {camera} -o to_{name}.out --to {name}" for name in FORMATS]
    lines += [f"convert to_{name}.out -o - --image-size 640x480" for name in FORMATS]
    lines += ["validate . --json", "fleet . -o fleet.html --verbose", "diff edited3.yaml " + camera]
    for i, flags in enumerate(["", "--keep all --interpolation cubic", "--keep valid --size 400x300", "--projection cylindrical",
                               "--projection equirectangular --fov 60", "--camera-only --fov 70 --json"]):
        lines.append(f"undistort {camera} '{images}' -o undistorted{i} {flags}")
    return lines


POINTS = "x,y,z\n" + "".join(f"{0.37 * i - 1},{0.21 * j - 0.6},{1 + 0.3 * ((i + j) % 3) - 1.2 * (i == 6)}\n"
                             for i in range(7) for j in range(7))
PIXELS = "u,v\n" + "".join(f"{53.7 * i - 20},{41.1 * j - 15}\n" for i in range(14) for j in range(13))
TABLES = {"points.csv": POINTS, "pixels.csv": PIXELS}


def opencv_jobs(quick):
    left, right = "opencv/left[0-9][0-9].jpg", "opencv/right[0-9][0-9].jpg"
    board = "--board checkerboard:9x6:25mm"
    detect = f"detect '{left}' {board} -o corners.csv"
    first = [detect, "calibrate corners.csv -o camera.yaml --evidence evidence.json",
             "calibrate corners.csv -o other.yaml --model rational --keep-untrustworthy"]
    pair = f"'{left}' '{right}'"
    jobs = [
        Job("opencv detect", [
            f"detect '{left}' {board} --debug drawn --json", f"detect '{left}' {board} -o corners.vnl --cache cache",
            f"detect '{left}' {board} --camera left --cache cache", "detect 'opencv/left0[1-3].jpg' --config config/detect.yaml",
            "detect opencv/left01.jpg --board checkerboard:8x6:25mm", "detect opencv/left01.jpg opencv/lena.jpg --board checkerboard:9x6:25mm",
            f"calibrate '{left}' {board} -o camera.yaml --debug debug --report page.html --evidence evidence.json",
            "calibrate 'opencv/left0[1-3].jpg'", "calibrate corners.vnl --board checkerboard:9x6:25mm --image-size 640x480 --json",
            f"report evidence.json -o again.html --images '{left}' --figures figures",
            "report camera.yaml --evidence evidence.json -o once.html --against camera.yaml"]),
        Job("opencv models", [detect, *calibrate_variants(quick)]),
        Job("opencv camera", [*first, *use_of_camera("camera.yaml", "opencv/left0[12].jpg", ["other.yaml"]),
                              f"validate camera.yaml --images '{left}' {board} --report page.html",
                              f"validate camera.yaml other.yaml --footage '{left}' --front-end keypoints"], TABLES),
        Job("opencv rig", [
            f"rig calibrate {pair} {board} -o rig.yaml --evidence rig.json --report rig.html --verbose",
            f"detect '{left}' {board} --camera left -o left.csv", f"detect '{right}' {board} --camera right -o right.csv",
            "rig calibrate left.csv right.csv --names left,right --json --model radtan --board-shape flat -o flat.yaml",
            "calibrate left.csv -o lens.yaml",
            "rig calibrate left.csv right.csv --fixed lens.yaml,- --verbose -o fixed.yaml --keep-untrustworthy",
            "rig validate rig.yaml left.csv right.csv", "rig validate rig.yaml left.csv right.csv --json",
            f"rig rectify rig.yaml 'opencv/left0[12].jpg' 'opencv/right0[12].jpg' -o rectified --maps {board}",
            "rig rectify rig.yaml -o cylindrical --camera-only --projection cylindrical --json",
            "rig rectify rig.yaml -o centred --camera-only --own-centres --keep valid",
            "rig triangulate rig.yaml pixels.csv", "rig triangulate rig.yaml pixels.csv --covariance -o points.csv --sigma 0.5",
            "rig triangulate rig.yaml pixels.csv --json", "validate rig.yaml --verbose", "validate rig.yaml --json",
            "diff rig.yaml flat.yaml --tolerance 0.5", "diff rig.yaml flat.yaml --json --distance 3m",
            f"report rig.json -o again.html --images {pair}", "convert rig.yaml#0 -o left.yaml", "project rig.yaml#1 < points.csv",
            *[f"convert rig.yaml -o rig_{name}.out --to {name}" for name in FORMATS],
            *[f"convert rig_{name}.out -o - --image-size 640x480" for name in FORMATS],
            "convert rig.yaml -o small.yaml --resize 320x240", "convert rig.yaml -o turned.yaml --rotate 90",
            "convert rig.yaml -o other.yaml --model rational"],
            {"pixels.csv": "id,camera,u,v\n" + "".join(
                f"p{i},{name},{100 + 40 * i - shift},{80 + 25 * i}\n" for i in range(10)
                for name, shift in (("left", 0), ("right", 12 + 7 * i)))}),
        Job("rendered", [
            "detect testdata/checkerboard/images --board checkerboard:9x6:25mm -o corners.csv --debug drawn",
            "calibrate testdata/checkerboard/corners.csv -o camera.yaml --report page.html --json",
            "handeye calibrate testdata/checkerboard/corners.csv --poses testdata/checkerboard/robot.csv -o handeye.yaml --verbose",
            "handeye calibrate testdata/checkerboard/corners.csv --poses testdata/checkerboard/robot.csv --camera camera.yaml --json "
            "--camera-on hand --tolerance 0.5mm -o handeye.urdf --to urdf",
            "handeye calibrate testdata/checkerboard/corners.csv --poses testdata/checkerboard/robot.csv --pose-form kuka --model pinhole "
            "--keep-untrustworthy --quiet -o other.yaml",
            "handeye validate handeye.yaml testdata/checkerboard/corners.csv --poses testdata/checkerboard/robot.csv --json",
            "validate testdata/camera_files testdata/checkerboard/camera.yaml --verbose", "validate testdata --json",
            "simulate config/scene.yaml -o scene --corners-only --json", "simulate config/footage.yaml -o footage --truth-only",
            "simulate config/scene.yaml -o scene --corners-only --overwrite"]),
    ]
    if quick:
        jobs[2].lines = [line for line in jobs[2].lines if "--footage" not in line and "undistorted4" not in line]
    return jobs


def spoiled_jobs(root):
    """Files that the fuzz tests found: each command says what is wrong with them. The key ends with the ending of the files."""
    commands = {"camera": "validate {} --verbose", "corners.csv": "calibrate {}", "board": "board {} -o board.svg",
                "scene": "simulate {} -o folder --corners-only --overwrite", "vnl.vnl": "calibrate {} --board checkerboard:9x6:25mm",
                "poses": "project testdata/checkerboard/camera.yaml points.csv --poses {}",
                "settings": "detect --config {} testdata/checkerboard/images/view_001.png",
                "table": "unproject testdata/checkerboard/camera.yaml {}", "image_file": "detect {} --board checkerboard:9x6:25mm",
                "video.avi": "detect {} --board checkerboard:9x6:25mm", "image_container": "detect {} --board checkerboard:9x6:25mm"}
    jobs = []
    for kind, command in commands.items():
        kind, dot, ending = kind.partition(".")
        folder = os.path.join(root, "testdata", "fuzz", kind)
        files = {"spoiled/" + name + dot + ending: os.path.join(folder, name) for name in sorted(os.listdir(folder))}
        jobs.append(Job("spoiled " + kind, [command.format(name) for name in files], TABLES))
        jobs[-1].links = files
    return jobs


def photograph_jobs(sets, quick):
    """The sets of checkerboards and other boards. `quick` names those to use, or is empty."""
    jobs = []
    for name, images, board in sets:
        if quick and name not in quick:
            continue
        lines = [f"detect '{images}' --board {board} -o corners.csv",
                 "calibrate corners.csv -o camera.yaml --evidence evidence.json --report page.html --verbose"
                 + (" --model radtan" if quick else " --keep-untrustworthy")]
        if not quick:
            lines += ["calibrate corners.csv --json --board-shape flat", f"calibrate '{images}' --board {board} -o again.yaml",
                      "calibrate corners.csv --model kannala_brandt -o wide.yaml --keep-untrustworthy",
                      "validate camera.yaml --images corners.csv --verbose --report validation.html",
                      "validate camera.yaml wide.yaml --json", "diff camera.yaml wide.yaml -o diff.svg",
                      f"report evidence.json -o report.html --images '{images}' --figures figures"]
        jobs.append(Job("set " + name, lines))
    return jobs


def real_rig_jobs(quick):
    lenses = "sleap_anipose_4cam_charuco/{}/calibration_images"
    bumblebee = "'real/bumblebee2_stereo_chess/left*.jpg' 'real/bumblebee2_stereo_chess/right*.jpg'"
    street = "'real/footage/boofcv_bumblebee_stereo/*_left.jpg' 'real/footage/boofcv_bumblebee_stereo/*_right.jpg'"
    scenes = ["chair01", "chair02", "garden01", "garden02", "lantern01", "stones01", "sundial01", "wall01"]
    jobs = [Job("rig bumblebee", [
        f"rig calibrate {bumblebee} --board checkerboard:4x6:30mm -o rig.yaml --evidence rig.json --report rig.html",
        f"rig validate rig.yaml {street} --footage --match frames.csv --json",
        f"rig validate rig.yaml {street} --footage --match frames.csv", f"rig validate rig.yaml {street} --footage"],
        {"frames.csv": "left,right\n" + "".join(f"{scene}_left.jpg,{scene}_right.jpg\n" for scene in scenes)})]
    if quick:
        jobs[0].lines.pop(1)
        return jobs
    sleap = " ".join("real/" + lenses.format(name) for name in ("back", "mid", "side", "top"))
    large = " ".join(f"real/large_charuco_corners/cam{i}.csv" for i in (1, 2, 3))
    videos = " ".join(f"real/webcams_charuco/calibration/extrinsic/cam_{i}.mp4" for i in range(4))
    return [*jobs,
            Job("rig sleap", [f"rig calibrate {sleap} --names back,mid,side,top --board {SLEAP} -o rig.yaml --verbose "
                              "--evidence rig.json --report rig.html --keep-untrustworthy",
                              f"rig validate rig.yaml {sleap} --board {SLEAP} --json", "validate rig.yaml --verbose"]),
            Job("rig large", [f"rig calibrate {large} -o rig.yaml --board-shape warp --json --keep-untrustworthy",
                              "calibrate real/large_charuco_corners/cam1.csv -o camera.yaml --verbose --board-shape warp"]),
            Job("rig webcams", [f"rig calibrate {videos} --frames 40 --board charuco:4x5:54mm:40.5mm:DICT_4X4_1000 -o rig.yaml "
                                "--evidence rig.json --keep-untrustworthy"])]


def footage_jobs(quick):
    jobs = []
    for name, pictures, model, size, numbers in FOOTAGE:
        values = [float(number) for number in numbers.split()]
        wrong = [0.9 * value if i < 2 else value for i, value in enumerate(values)]
        files = {"true.yaml": camera_text(model, size, values), "wrong.yaml": camera_text(model, size, wrong)}
        lines = [f"validate true.yaml wrong.yaml --footage 'real/footage/{pictures}' --report page.html --verbose",
                 f"track 'real/footage/{pictures}' --camera true.yaml -o path.txt --map map.ply",
                 f"validate true.yaml wrong.yaml --footage 'real/footage/{pictures}' --json --junit junit.xml"]
        jobs.append(Job("footage " + name, lines, files))
    return [] if quick else jobs


def report_jobs(data):
    """Files of public reports, most of them in formats of other tools, and damaged photographs."""
    folder = os.path.join(data, "reports")
    if not os.path.isdir(folder):
        return []
    lines = []
    for case in sorted(os.listdir(folder)):
        if not os.path.isdir(os.path.join(folder, case)):
            continue
        for name in sorted(os.listdir(os.path.join(folder, case))):
            path = f"real/reports/{case}/{name}"
            lines += [f"validate {path} --verbose --image-size 1280x720 --read-as radtan", f"convert {path} -o camera.yaml --json"]
    return [Job("reports", [*lines, "calibrate 'real/reports/63_fisheye_corners/view*.csv' -o fisheye.yaml --verbose",
                            "validate real/reports --json"]),
            Job("damaged photographs", ["detect real/hostile/damaged_jpegs --board checkerboard:9x6:25mm",
                                        "detect real/hostile/crash1.png --board checkerboard:9x6:25mm",
                                        "calibrate real/hostile/corners.csv"])]


# Simulated sets --------------------------------------------------------------------------------------------------------


def board_set(rng, index):
    """One camera. Every fifth set is rendered; the others are corners with noise."""
    is_rendered = index % 5 == 4
    board = BOARDS[(index + index // 10) % len(BOARDS)]
    model = rng.choice(MODELS)
    width, height = rng.choice([(640, 480), (480, 640)] if is_rendered else
                               [(640, 480), (1280, 720), (1920, 1200), (480, 640)])
    noise = 0 if is_rendered else rng.choice([0.02, 0.1, 0.3])
    num_views = rng.randint(4, 6) if is_rendered else rng.randint(4, 30)
    texts = {"scene.yaml": f"alidade_scene: 1\ncamera: {drawn_camera(rng, model, width, height)}\nboard: {board}\n"
                           f"views: {{random: {num_views}}}\nseed: {rng.randint(1, 10**6)}\n"
                           f"random: {{max_tilt_deg: {rng.randint(10, 55)}, max_roll_deg: 30, min_fill: 0.3, max_fill: 0.8}}\n"
                           f"render: {{blur_px: 0.8, read_noise: {rng.choice([0, 1.5, 4])}}}\ncorner_noise_px: {noise}\n", **TABLES}
    chosen = rng.choice(["", "", "", f"--model {model}", f"--model {rng.choice(MODELS)}", "--board-shape warp", "--same-focal"])
    target = rng.choice(FORMATS)
    found = "sim/corners.csv"
    lines = ["simulate scene.yaml -o sim" + ("" if is_rendered else " --corners-only")]
    if is_rendered:
        lines.append(f"detect sim/images --board {board} -o corners.csv")
        found = "corners.csv"
    lines += [f"calibrate {found} {chosen} -o camera.yaml --evidence evidence.json --report page.html --keep-untrustworthy --verbose",
              f"validate camera.yaml --images sim/corners.csv --against sim/camera.yaml --json", "diff sim/camera.yaml camera.yaml -o diff.svg",
              f"convert camera.yaml -o out.{target} --to {target}", f"convert out.{target} -o back.yaml --image-size {width}x{height}",
              f"convert camera.yaml -o small.yaml --resize {width // 2}x{height // 2} --model {rng.choice(MODELS)}",
              "project camera.yaml points.csv --jacobian", "unproject camera.yaml pixels.csv", "report evidence.json -o report.html"]
    if is_rendered:
        lines.append("undistort camera.yaml sim/images/view_001.png -o undistorted --keep valid")
    return Job(f"simulated {index} board", lines, texts)


def turn(rng, angle):
    """Returns a rotation (x, y, z, w) about a random axis by at most an angle."""
    axis = [rng.gauss(0, 1) for _ in range(3)]
    length = math.sqrt(sum(x * x for x in axis))
    half = rng.uniform(0, angle) / 2
    return [*(math.sin(half) * x / length for x in axis), math.cos(half)]


def product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz]


def rotated(q, p):
    x, y, z, _ = product(product(q, [*p, 0]), [-q[0], -q[1], -q[2], q[3]])
    return [x, y, z]


def rig_set(rng, index):
    """Two to four cameras that look into one direction, 80 mm from each to the next."""
    board = BOARDS[index // 10 % 3]
    names = ["front", "left", "right", "rear"][:rng.randint(2, 4)]
    boards = [(turn(rng, 0.7), [rng.uniform(-0.2, 0.1), rng.uniform(-0.15, 0.05), rng.uniform(0.4, 0.9)])
              for _ in range(rng.randint(6, 14))]
    texts = {}
    lines = []
    for i, name in enumerate(names):
        pose_q, pose_t = turn(rng, 0.1), [-0.08 * i, rng.uniform(-0.005, 0.005), rng.uniform(-0.005, 0.005)]
        poses = ""
        for board_q, board_t in boards:
            q = product(pose_q, board_q)
            t = [a + b for a, b in zip(rotated(pose_q, board_t), pose_t)]
            poses += f"    - {{quaternion_xyzw: {[float(f'{x:.15g}') for x in q]}, translation_m: {[float(f'{x:.12g}') for x in t]}}}\n"
        camera = drawn_camera(rng, rng.choice(["radtan", "radtan", "pinhole", "kannala_brandt", "double_sphere"]), 960, 720)
        texts[name + ".yaml"] = (f"alidade_scene: 1\ncamera: {camera}\nboard: {board}\nviews:\n  poses:\n{poses}"
                                 f"seed: {rng.randint(1, 10**6)}\ncorner_noise_px: 0.1\n")
        lines.append(f"simulate {name}.yaml -o {name} --corners-only")
    inputs = " ".join(name + "/corners.csv" for name in names)
    texts["pixels.csv"] = "id,camera,u,v\n" + "".join(
        f"{p},{name},{rng.uniform(200, 700):.3f},{rng.uniform(150, 500):.3f}\n" for p in range(10) for name in names)
    lines += [f"rig calibrate {inputs} --names {','.join(names)} -o rig.yaml --evidence rig.json --report rig.html --verbose "
              "--keep-untrustworthy", f"rig validate rig.yaml {inputs} --json", "validate rig.yaml --verbose",
              f"rig rectify rig.yaml -o rectified --cameras {names[0]},{names[1]} --camera-only", "rig triangulate rig.yaml pixels.csv",
              "convert rig.yaml -o chain.yaml --to kalibr", "diff rig.yaml chain.yaml", "report rig.json -o page.html"]
    return Job(f"simulated {index} rig", lines, texts)


def footage_set(rng, index):
    model = rng.choice(["pinhole", "radtan", "kannala_brandt"])
    surroundings, path = rng.choice([("room", "walk"), ("room", "walk"), ("plane", "walk"), ("far", "rotation"), ("room", "straight")])
    texts = {"scene.yaml": f"alidade_scene: 1\ncamera: {drawn_camera(rng, model, 320, 240)}\n"
                           f"footage: {{surroundings: {surroundings}, path: {path}, frames: {rng.randint(8, 16)}, flow_px: 6, "
                           f"moving_objects: {rng.randint(0, 3)}, rolling_shutter: {rng.choice([0, 0, 0.5])}}}\n"
                           f"seed: {rng.randint(1, 10**6)}\nrender: {{blur_px: 0.7, read_noise: 1.5}}\n"}
    pictures = "'sim/images/frame_%05d.png'"
    return Job(f"simulated {index} footage", [
        "simulate scene.yaml -o sim", "convert sim/camera.yaml -o wide.yaml --crop 0,0,320,230",
        f"validate sim/camera.yaml wide.yaml --footage {pictures} --verbose --report page.html",
        f"track {pictures} --camera sim/camera.yaml -o path.txt --map map.ply", f"track {pictures} --camera sim/camera.yaml -o again.txt --json --front-end keypoints"],
        texts)


def fleet_set(rng, index):
    """Cameras of one kind, one of which deviates, and their previous calibrations."""
    lines, texts = [], {}
    state = rng.getstate()
    for unit in range(6):
        rng.setstate(state)
        camera = drawn_camera(rng, "radtan", 640, 480)
        factor = 1 + 0.002 * unit + (0.05 if unit == 4 else 0)
        fx = float(camera.split("fx: ")[1].split(",")[0])
        camera = camera.replace(f"fx: {fx}", f"fx: {fx * factor:.6f}")
        for when in ("now", "before"):
            texts[f"{when}{unit}.yaml"] = (f"alidade_scene: 1\ncamera: {camera}\nboard: checkerboard:9x6:25mm\nviews: {{random: 12}}\n"
                                           f"seed: {index * 100 + unit * 2 + (when == 'now')}\ncorner_noise_px: 0.1\n")
            lines += [f"simulate {when}{unit}.yaml -o {when}{unit} --corners-only",
                      f"calibrate {when}{unit}/corners.csv --model radtan --serial {unit} -o {when}/unit{unit}.yaml --quiet --keep-untrustworthy"]
    texts["now/notes.txt"] = texts["before/notes.txt"] = "The folders must exist.\n"
    lines += ["fleet now -o fleet.html --typical typical.yaml --verbose", "fleet now --previous before -o fleet.csv --json",
              "fleet now before --tolerance 0.5px --same-frame --strict", "fleet typical.yaml"]
    return Job(f"simulated {index} fleet", lines, texts)


def simulated_jobs(indices):
    """Of ten sets, seven are boards, and one each a rig, footage and a fleet."""
    jobs = []
    for index in indices:
        rng = random.Random(1000 + index)
        make = {3: rig_set, 6: footage_set, 8: fleet_set}.get(index % 10, board_set)
        jobs.append(make(rng, index))
    return jobs


def jobs(root, quick, num_sets):
    """Returns the jobs, and the names of the sets that are not there."""
    opencv, checkerboards = real_data_sets(root)
    data = os.environ.get("ALIDADE_REAL_DATA", "")
    links = {"testdata": os.path.join(root, "testdata"), "config": os.path.join(root, "config")}
    missing = []
    found = [*spoiled_jobs(root), *help_jobs(), *printed_jobs(), *simulated_jobs([index for index in range(num_sets) if not quick or index in QUICK_SETS])]
    if quick:  # a part of the spoiled files
        for job in found:
            if job.name.startswith("spoiled"):
                job.lines = job.lines[::8]
    sets = []
    if os.path.isdir(opencv):
        links["opencv"] = opencv
        found = [*opencv_jobs(quick), *found]
        sets += [(name, "opencv/" + os.path.basename(images), board)
                 for name, images, board in checkerboards if images.startswith(opencv)]
    else:
        missing.append("the photographs of opencv-doc")
    if os.path.isdir(data):
        links["real"] = os.path.abspath(data)
        sets += [(name, "real/" + images, board) for name, images, board in [*checkerboards, *OTHER_SETS]
                 if not images.startswith("/")]
        found = [*real_rig_jobs(quick), *footage_jobs(quick), *found, *report_jobs(data)]
    else:
        missing.append("the sets of ALIDADE_REAL_DATA")
    chosen = ["sony_chess", "photonvision gloworm", "sony circles", "charuco 2024-05-07_lifecam_480"]
    found = [*photograph_jobs(sets, chosen if quick else []), *found]
    for job in found:
        job.links = {**job.links, **links}
    return found, missing
