//! What `trocar detect --help` teaches below the flags. A paragraph is a line: the terminal's width wraps it.

pub(super) const MORE: &str = "\
Many recordings:
  trocar detect trials/ more/x.csv --labels labels.csv

A folder stands for its *.csv files, in the order of their names. They are read in parallel; tables, files and errors come in \
the order given, whatever the number of threads. What cannot be read is reported and the others go on: exit code 2.

Each recording has a folder of its name in --out (a second x.csv has x-2) with detection.csv, detection.json, events.csv and \
figures. Beside them are detections.json, events.csv of all, timeline.png (phases, ruptures and alarms, a row per recording) \
and, with labels, delays.png.

Labels, as a CSV file:
  file,time_s,kind
  x.csv,5.52,capsule
  quiet.csv,,

A file is named as on the command line, or by its own name if that is one recording's only. Times are the recording's own, in \
s, in any order; the kind may be left out. An empty time says that there is no rupture in the recording; a recording that is \
not named is not judged. Without --labels, x.labels.csv beside x.csv serves: time_s[,kind], no row meaning no rupture.

An alarm announces at most one rupture, and a rupture has at most one alarm, which comes with it or at most --window-s after \
it. Of all such pairings the one with the most pairs counts, then the one with the least delays. An alarm before its rupture \
is false. A share or a rate of nothing is undefined: — in tables, null in JSON.

Phases, from the positions alone: free above the contact; in contact, insertion where the mean speed over 0.1 s is above \
1 mm/s, withdrawal where it is below -1 mm/s, hold between. What lasts less than 0.1 s belongs to what was before it.

Live stream:
  rig | trocar detect - --time t_s --position x_mm:1e-3 --force f_n --interval-s 0.001

A header line, then a line per sample. Memory is constant and no file is written. Each alarm is a CSV row (with --json a line \
of JSON) on standard output as soon as its sample has come; --every 100 adds every hundredth sample.

A row that is malformed, not finite or not later than the last one is skipped with a warning. Up to nine lost samples in a row \
are interpolated; after a longer gap, or when the clock was set back, all begins anew. At the end of the input, on Ctrl-C and on \
SIGTERM a summary goes to standard error (with --json, to standard output). The exit code is 0 even if rows were skipped: a \
rig's hiccup is no mistake in the command, and the summary counts them. It is 2 if not one sample could be used.

Without --velocity, give the encoder's step: --set sensor.position_resolution_m=1e-5 (1 µm is assumed).

Exit codes: 0 done, 1 the work failed, 2 the input is wrong, 130 interrupted by Ctrl-C (a live stream: by the second one).";
