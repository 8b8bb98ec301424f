#!/usr/bin/env bash
# End-to-end throughput of `alidade project` and `unproject` on a table of random points, next to counting the lines of
# the same file and copying it: bench/stream_bench.sh ALIDADE CAMERA [POINTS] (bench/README.md).
set -euo pipefail
alidade=$1
camera=$2
count=${3:-1000000}
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
points=$folder/points.csv
pixels=$folder/pixels.csv
pose='{rotation_vector_rad: [0, 0.02, 0.01], translation_m: [0.01, 0, 0.5]}'

# 17 significant digits are what doubles take at worst; the shortest texts of random ones have about as many.
awk -v n="$count" 'BEGIN { srand(1); print "x,y,z"; for (i = 0; i < n; ++i) { z = 1 + 2 * rand();
  printf "%.17g,%.17g,%.17g\n", (rand() - 0.5) * z, 0.7 * (rand() - 0.5) * z, z } }' > "$points"
echo "$count points, $(($(stat -c %s "$points") >> 20)) MiB; the best of five runs of each"

# Seconds by the clock and of processor time, million points a second by each, and the peak memory.
measure() {
  local name=$1 out=$2
  shift 2
  for _ in 1 2 3 4 5; do
    /usr/bin/time -q -f '%e %U %S %M' -o "$folder/time" "$@" > "$out" 2> /dev/null
    cat "$folder/time"
  done | awk -v n="$count" -v name="$name" '
    { wall = $1 > 0 ? $1 : 0.01; cpu = $2 + $3 > 0 ? $2 + $3 : 0.01; if (NR == 1 || wall < w) w = wall;
      if (NR == 1 || cpu < c) c = cpu; if ($4 > m) m = $4 }
    END { printf "%-20s %8.2f s %8.2f M/s | %8.2f s %8.2f M/s | %5.0f MB\n", name, w, n / w / 1e6, c, n / c / 1e6,
          m / 1024 }'
}

echo "                              by the clock  |      processor time  | memory"
measure "project" "$pixels" "$alidade" project "$camera" "$points"
measure "project --pose" "$folder/out" "$alidade" project "$camera" "$points" --pose "$pose"
measure "project --jacobian" "$folder/out" "$alidade" project "$camera" "$points" --jacobian
measure "unproject" "$folder/out" "$alidade" unproject "$camera" "$pixels"
measure "no points" "$folder/out" "$alidade" project "$camera" /dev/null
measure "wc -l" "$folder/out" wc -l "$points"
measure "cat" "$folder/out" cat "$points"
