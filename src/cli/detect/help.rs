//! Each paragraph is one line, which clap wraps.

pub(super) const MORE: &str = "\
The detector is the adaptive one, which needs no contact position, no threshold and no calibration (`trocar explain detector.distance`). \
A key of [detector] that it does not use, given by --set, --settings or a scenario file, selects the detector of that key: \
--set detector.distance=squared-residual is the paper's.

Many recordings:
  trocar detect trials/ more/x.csv --labels labels.csv

A folder means its *.csv files, or without any its files of other formats, in the order of their names, without the file of --labels. They are read in parallel; tables, files and errors have the order \
of the arguments. A recording that cannot be read is reported, the others continue, and the exit code is 2.

Each recording has a folder with its name in DIR/detect (a second x.csv has x-2), with detection.csv, detection.json, events.csv and \
figures. DIR/detect also has detections.json, a common events.csv, the figure timeline (phases, ruptures and alarms, a row per recording) and, \
with labels, the figure delays.

Labels, as a CSV file:
  file,time_s,kind
  x.csv,5.52,capsule
  quiet.csv,,

A file is named as on the command line, or by its file name if that is unique. Times are in the time of the recording, in s, in \
any order. The kind is optional. An empty time means that the recording has no rupture. A recording without labels has no scores. \
Without --labels, the labels of x.csv are read from x.labels.csv in the same folder: time_s[,kind]; no row means no rupture.

An alarm matches at most one rupture, and a rupture at most one alarm. The alarm is at the rupture or at most --within-s later. \
The matching has the maximum number of pairs, and among those the minimum total delay. An alarm before its rupture is false. A share \
or a rate without samples is undefined: — in tables, null in JSON.

Phases depend on the positions only: free without contact; in contact, insertion if the mean speed over 0.1 s is above 1 mm/s, \
withdrawal if it is below -1 mm/s, hold otherwise. An interval shorter than 0.1 s belongs to the previous phase.

Live stream:
  rig | trocar detect - --time t_s --position x_mm:1e-3 --force f_n --interval-s 0.001

The input is a header line, then a line per sample. Memory is constant and no file is written. Each alarm is printed at once as a \
CSV row (with --json, a line of JSON) on standard output; --every 100 also prints every hundredth sample.

A row that is malformed, not finite or not later than the previous row is skipped with a warning. Up to nine consecutive lost \
samples are interpolated. After a longer gap, or if the clock is set back, the detection restarts. At the end of the input, on \
Ctrl-C and on SIGTERM, a summary is printed on standard error (with --json, on standard output). The summary counts skipped rows; \
they do not change the exit code, which is 0. It is 2 without any usable sample.

Without --velocity, set the resolution of the encoder: --set sensor.position_resolution_m=1e-5 (the default is 1 µm).

Exit codes: 0 success, 1 failure, 2 invalid input, 130 interrupted by Ctrl-C (for a live stream: by the second Ctrl-C).";
