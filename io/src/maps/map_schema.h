// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

/** \file
 * The tables of a map file. One list of columns per table serves writing and reading. */

namespace facetloc::schema {

/** \brief STRICT tables with CHECKs: the file itself refuses nonsense, whoever writes it.
 *
 * Metres, radians, seconds. Poses tx ty tz qx qy qz qw. A later minor version may add columns and tables
 * only. */
inline constexpr const char* kTables = R"sql(
CREATE TABLE meta(               -- how the map was made, and conventions in words
  key TEXT PRIMARY KEY,
  value TEXT NOT NULL
) STRICT, WITHOUT ROWID;

CREATE TABLE camera(             -- that the models' images were taken with; one row or none
  id INTEGER PRIMARY KEY CHECK(id = 0),
  width INTEGER, height INTEGER, -- intrinsics of its full images [px]; NULL while each image has its own
  fx REAL, fy REAL, cx REAL, cy REAL,
  inverse_depth_std REAL NOT NULL CHECK(inverse_depth_std > 0),  -- random error of 1/z [1/m] ...
  depth_std REAL NOT NULL CHECK(depth_std >= 0),                 -- ... of z, the same at all depths [m] ...
  depth_std_slope REAL NOT NULL CHECK(depth_std_slope >= 0),     -- ... and as a share of z
  distortion_offset REAL NOT NULL CHECK(distortion_offset >= 0), -- smooth distortion that it may have [1/m] ...
  distortion_slope REAL NOT NULL CHECK(distortion_slope >= 0),   -- ... and per unit of the normalised ray
  max_depth REAL CHECK(max_depth > 0),           -- farther pixels were left out [m]; NULL = none
  mount_height REAL, mount_tilt_deg REAL,        -- on a robot: above the floor [m], below the horizon [deg]; NULL = unknown
  mount_roll_deg REAL, mount_pan_deg REAL,       -- about the optical axis, the right side lower; to the left
  mount_x REAL, mount_y REAL,                    -- of the optical centre ahead of the base and to its left [m]
  distortion_left REAL, distortion_top REAL,     -- normalised rays of the first and the last node of the distortion
  distortion_right REAL, distortion_bottom REAL, -- that was taken out of the models' images; NULL = none
  distortion BLOB CHECK(length(distortion) % 8 = 0),  -- measured minus true 1/z [1/m]: float64 little-endian, row by row,
                                                      -- bilinear between the nodes
  CHECK((width IS NULL) = (height IS NULL) AND (height IS NULL) = (fx IS NULL) AND (fx IS NULL) = (fy IS NULL) AND
        (fy IS NULL) = (cx IS NULL) AND (cx IS NULL) = (cy IS NULL)),
  CHECK((mount_height IS NULL) = (mount_tilt_deg IS NULL) AND (mount_tilt_deg IS NULL) = (mount_roll_deg IS NULL) AND
        (mount_roll_deg IS NULL) = (mount_pan_deg IS NULL) AND (mount_pan_deg IS NULL) = (mount_x IS NULL) AND
        (mount_x IS NULL) = (mount_y IS NULL)),
  CHECK((distortion IS NULL) = (distortion_left IS NULL) AND (distortion IS NULL) = (distortion_top IS NULL) AND
        (distortion IS NULL) = (distortion_right IS NULL) AND (distortion IS NULL) = (distortion_bottom IS NULL))
) STRICT;

CREATE TABLE ambiguity(          -- how easily the places of the map are confused; one row or none
  id INTEGER PRIMARY KEY CHECK(id = 0),
  score REAL NOT NULL,           -- of wrong places for the map's own views, mean of the highest tenth [nats]
  views INTEGER NOT NULL CHECK(views > 0)  -- that were asked for
) STRICT;

CREATE TABLE model(              -- local models, numbered 0, 1, 2, ...
  id INTEGER PRIMARY KEY CHECK(id >= 0),
  name TEXT NOT NULL UNIQUE,
  stamp REAL NOT NULL,           -- [s]
  tx REAL, ty REAL, tz REAL,     -- T_w_m: the model's camera frame in the world; NULL while unknown
  qx REAL, qy REAL, qz REAL, qw REAL,
  width INTEGER NOT NULL CHECK(width > 0),    -- intrinsics of the working image [px]
  height INTEGER NOT NULL CHECK(height > 0),
  fx REAL NOT NULL CHECK(fx > 0), fy REAL NOT NULL CHECK(fy > 0),
  cx REAL NOT NULL, cy REAL NOT NULL,
  num_segments INTEGER NOT NULL CHECK(num_segments >= 0),
  lookalike_score REAL,          -- of the best wrong place for its view [nats]; NULL if none is known
  CHECK((tx IS NULL) = (ty IS NULL) AND (ty IS NULL) = (tz IS NULL) AND (tz IS NULL) = (qx IS NULL) AND
        (qx IS NULL) = (qy IS NULL) AND (qy IS NULL) = (qz IS NULL) AND (qz IS NULL) = (qw IS NULL)),
  CHECK(qw IS NULL OR abs(qx * qx + qy * qy + qz * qz + qw * qw - 1) < 1e-6)
) STRICT;

CREATE TABLE segment(            -- F = (R_F, t_F, Sigma_q, Sigma_p) in the frame of its model, the most useful first
  model_id INTEGER NOT NULL REFERENCES model(id) ON DELETE CASCADE,
  idx INTEGER NOT NULL CHECK(idx >= 0),
  tx REAL NOT NULL, ty REAL NOT NULL, tz REAL NOT NULL,  -- t_F: centroid of the supporting points
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,  -- R_F: z axis = normal, away from the camera
  var_sx REAL NOT NULL CHECK(var_sx > 0), cov_sx_sy REAL NOT NULL, cov_sx_r REAL NOT NULL,  -- Sigma_q, q = (s_x, s_y, r)
  var_sy REAL NOT NULL CHECK(var_sy > 0), cov_sy_r REAL NOT NULL,
  var_r REAL NOT NULL CHECK(var_r > 0),
  lambda1 REAL NOT NULL, lambda2 REAL NOT NULL,          -- eigenvalues of Sigma_p [m^2]
  num_points INTEGER NOT NULL CHECK(num_points >= 0),    -- support [px of the working image]
  hull BLOB NOT NULL CHECK(length(hull) % 8 = 0),        -- (x, y) float32 little-endian pairs in S_F, counter-clockwise
  PRIMARY KEY(model_id, idx),
  CHECK(lambda1 >= lambda2 AND lambda2 >= 0),
  CHECK(abs(qx * qx + qy * qy + qz * qz + qw * qw - 1) < 1e-6)
) STRICT, WITHOUT ROWID;

CREATE TABLE depth_picture(      -- small inverse-depth picture of a model for dense checks; the map is usable without
  model_id INTEGER PRIMARY KEY REFERENCES model(id) ON DELETE CASCADE,
  width INTEGER NOT NULL CHECK(width > 0),    -- intrinsics of the picture [px]
  height INTEGER NOT NULL CHECK(height > 0),
  fx REAL NOT NULL CHECK(fx > 0), fy REAL NOT NULL CHECK(fy > 0),
  cx REAL NOT NULL, cy REAL NOT NULL,
  inverse_depth_std REAL NOT NULL CHECK(inverse_depth_std > 0),  -- noise of the picture, as the camera's
  depth_std REAL NOT NULL CHECK(depth_std >= 0),
  depth_std_slope REAL NOT NULL CHECK(depth_std_slope >= 0),
  encoding TEXT NOT NULL,        -- of data: see DepthBlob
  data BLOB NOT NULL             -- 1/z [1/16384 per m], 0 = unknown
) STRICT;

CREATE TABLE link(               -- topological links
  id INTEGER PRIMARY KEY CHECK(id >= 0),
  from_id INTEGER NOT NULL REFERENCES model(id) ON DELETE CASCADE,
  to_id INTEGER NOT NULL REFERENCES model(id) ON DELETE CASCADE,
  tx REAL NOT NULL, ty REAL NOT NULL, tz REAL NOT NULL,  -- T_from_to
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  c_rx_rx REAL NOT NULL, c_rx_ry REAL NOT NULL, c_rx_rz REAL NOT NULL,     -- its covariance, left decoupled perturbation:
  c_rx_tx REAL NOT NULL, c_rx_ty REAL NOT NULL, c_rx_tz REAL NOT NULL,     -- R <- Exp(r) R, t <- t + dt
  c_ry_ry REAL NOT NULL, c_ry_rz REAL NOT NULL,
  c_ry_tx REAL NOT NULL, c_ry_ty REAL NOT NULL, c_ry_tz REAL NOT NULL,
  c_rz_rz REAL NOT NULL,
  c_rz_tx REAL NOT NULL, c_rz_ty REAL NOT NULL, c_rz_tz REAL NOT NULL,
  c_tx_tx REAL NOT NULL, c_tx_ty REAL NOT NULL, c_tx_tz REAL NOT NULL,
  c_ty_ty REAL NOT NULL, c_ty_tz REAL NOT NULL,
  c_tz_tz REAL NOT NULL,
  UNIQUE(from_id, to_id),
  CHECK(from_id <> to_id),
  CHECK(abs(qx * qx + qy * qy + qz * qz + qw * qw - 1) < 1e-6)
) STRICT;

CREATE TABLE place_index(        -- what PlaceIndex has written, in parts; gone when a model is added
  part INTEGER PRIMARY KEY CHECK(part >= 0),  -- 0, 1, 2, ...
  crc32 INTEGER NOT NULL,        -- of data
  data BLOB NOT NULL
) STRICT;
)sql";

/** \brief Made in maps that hold gravity. */
inline constexpr const char* kGravityTable = R"sql(
CREATE TABLE gravity(            -- when the image of a model was taken, if it was measured
  model_id INTEGER PRIMARY KEY REFERENCES model(id) ON DELETE CASCADE,
  x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,  -- unit vector downwards, in the model's camera frame
  std REAL NOT NULL CHECK(std > 0),  -- about each of two horizontal axes [rad]
  CHECK(abs(x * x + y * y + z * z - 1) < 1e-6)
) STRICT;
)sql";

/** \brief Tables without which a file is no map. */
inline constexpr std::array<const char*, 8> kTableNames = {
    "meta", "camera", "ambiguity", "model", "segment", "depth_picture", "link", "place_index"};

inline constexpr const char* kModelColumns =
    "id, name, stamp, tx, ty, tz, qx, qy, qz, qw, width, height, fx, fy, cx, cy, num_segments, "
    "lookalike_score";
inline constexpr const char* kSegmentColumns =
    "model_id, idx, tx, ty, tz, qx, qy, qz, qw, var_sx, cov_sx_sy, cov_sx_r, var_sy, cov_sy_r, var_r, "
    "lambda1, lambda2, num_points, hull";
/** \brief All but the pixels. */
inline constexpr const char* kPictureHeadColumns =
    "model_id, width, height, fx, fy, cx, cy, inverse_depth_std, depth_std, depth_std_slope";
inline constexpr const char* kPictureColumns =
    "model_id, width, height, fx, fy, cx, cy, inverse_depth_std, depth_std, depth_std_slope, encoding, data";
inline constexpr const char* kLinkColumns =
    "id, from_id, to_id, tx, ty, tz, qx, qy, qz, qw, "
    "c_rx_rx, c_rx_ry, c_rx_rz, c_rx_tx, c_rx_ty, c_rx_tz, c_ry_ry, c_ry_rz, c_ry_tx, c_ry_ty, c_ry_tz, "
    "c_rz_rz, c_rz_tx, c_rz_ty, c_rz_tz, c_tx_tx, c_tx_ty, c_tx_tz, c_ty_ty, c_ty_tz, c_tz_tz";

inline constexpr const char* kConventions = "metres, radians, seconds; T_a_b maps coordinates of frame b "
                                            "into a; frames: w world, m local model (camera optical "
                                            "frame of its image: x right, y down, z forward), F segment (z "
                                            "axis = normal, away from the camera); quaternions "
                                            "x y z w; covariances of poses in the order (rotation, "
                                            "translation) of a left, decoupled perturbation; q = (s_x, s_y, "
                                            "r): tilts about the axes of F and offset along its normal";

inline constexpr const char* kCameraColumns =
    "id, width, height, fx, fy, cx, cy, inverse_depth_std, depth_std, depth_std_slope, distortion_offset, "
    "distortion_slope, max_depth, mount_height, mount_tilt_deg, mount_roll_deg, mount_pan_deg, mount_x, "
    "mount_y, distortion_left, distortion_top, distortion_right, distortion_bottom, distortion";
inline constexpr const char* kAmbiguityColumns = "id, score, views";
inline constexpr const char* kGravityColumns = "model_id, x, y, z, std";
inline constexpr const char* kIndexColumns = "part, crc32, data";

inline std::string select(const std::string& columns, const std::string& table) {
  return "SELECT " + columns + " FROM " + table;
}

/** \brief An INSERT with one placeholder per column. */
inline std::string insert(const std::string& columns, const std::string& table) {
  std::string places = "?";
  for (const char c : columns)
    if (c == ',') places += ",?";
  return "INSERT INTO " + table + "(" + columns + ") VALUES(" + places + ")";
}

}  // namespace facetloc::schema
