# SPDX-License-Identifier: BSD-3-Clause
# Rows of tables from results of facetloc_localize; sourced by the scripts that print figures. Needs $apps, the folder of the tools.

rowHead() {
  echo "| images | right within | n | correct | rank 1 | mean error | sure | of these right |"
  echo "|---|---|---|---|---|---|---|---|"
}

# row NAME RESULTS QUERY MAP METRES DEGREES [COLUMN [OPTION...]]: evaluates and prints one row. COLUMN: of the evaluation's tables.csv,
# "all (new)" unless given; OPTION: of facetloc_evaluate.
row() {
  local name=$1 results=$2 query=$3 map=$4 metres=$5 degrees=$6 column=${7:-all (new)}
  "$apps/facetloc_evaluate" "$results" "$query" --map "$map" --quiet --evaluation.max_translation "$metres" \
    --evaluation.max_rotation_deg "$degrees" "${@:8}" > "$results.evaluation.log"
  awk -F, -v name="$name" -v within="$metres m, $degrees°" -v column="$column" '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i == column) c = i
              if (!c) { print "rows.sh: tables.csv has no column \"" column "\"" > "/dev/stderr"; failed = 1; exit 1 } }
    { key = $1 "/" $2 "/" $3; if (!(key in value)) value[key] = $c }
    function share(n, of) { return of > 0 ? sprintf("%.1f %%", 100 * n / of) : "-" }
    END {
      if (failed) exit 1
      n = value["I//Total"]; sure = value["states//Sure"]
      correct = value["I//Correct hypothesis"]
      mean = correct > 0 ? sprintf("%.0f mm, %.2f°", value["II/Translation error [mm]/Avg."], value["II/Orientation error [deg]/Avg."]) : "-"
      printf "| %s | %s | %d | %s | %s | %s | %d | %s |\n", name, within, n, share(correct, n),
             share(value["beyond//Rank 1 correct"], n), mean, sure, share(value["states//correct"], sure) }
  ' "$results/evaluation/tables.csv"
}
