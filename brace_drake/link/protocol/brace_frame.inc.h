static inline uint16_t brace_crc16(const uint8_t *data, size_t size) {
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < size; ++i) {
    crc ^= (uint16_t)(data[i] << 8);
    for (int bit = 0; bit < 8; ++bit)
      crc = (uint16_t)(crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1);
  }
  return crc;
}

/* The seal: CRC-32 (reflected 0xEDB88320) begun at the session's number. */
static inline uint32_t brace_seal(const uint8_t *data, size_t size,
                                  uint32_t session) {
  uint32_t crc = ~session;
  for (size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit)
      crc = crc & 1 ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
  }
  return ~crc;
}

/* Writes the stuffed bytes, at most size + size / 254 + 1; returns how many. */
static inline size_t brace_stuff(const uint8_t *data, size_t size,
                                 uint8_t *out) {
  size_t code_at = 0, at = 1;
  uint8_t code = 1;
  for (size_t i = 0; i < size; ++i) {
    if (data[i] != 0) {
      out[at++] = data[i];
      ++code;
    }
    if (data[i] == 0 || (code == 0xFF && i + 1 < size)) {
      out[code_at] = code;
      code_at = at++;
      code = 1;
    }
  }
  out[code_at] = code;
  return at;
}

/* Undoes brace_stuff; out has room for size bytes. 0: codes do not fit. */
static inline size_t brace_unstuff(const uint8_t *data, size_t size,
                                   uint8_t *out) {
  size_t at = 0, written = 0;
  while (at < size) {
    uint8_t code = data[at++];
    if (code == 0 || at + code - 1 > size) return 0;
    for (uint8_t i = 1; i < code; ++i) out[written++] = data[at++];
    if (code < 0xFF && at < size) out[written++] = 0;
  }
  return written;
}

/* Makes a frame with its delimiters; `body` is header and payload. The room
 * needed is BRACE_LONGEST_FRAME for both arrays. Returns the frame's size. */
static inline size_t brace_make_frame(const uint8_t *body, size_t size,
                                      uint8_t *frame) {
  uint8_t checked[BRACE_LONGEST_FRAME];
  uint16_t crc = brace_crc16(body, size);
  memcpy(checked, body, size);
  checked[size] = (uint8_t)(crc & 0xFF);
  checked[size + 1] = (uint8_t)(crc >> 8);
  frame[0] = 0;
  size_t length = brace_stuff(checked, size + 2, frame + 1);
  frame[length + 1] = 0;
  return length + 2;
}

/* Takes what lay between two delimiters apart. Returns the size of header and
 * payload in `body`, or 0 for anything that is not exactly a message. */
static inline size_t brace_open_frame(const uint8_t *chunk, size_t size,
                                      uint8_t *body) {
  struct brace_header header;
  if (size > BRACE_LONGEST_FRAME) return 0;
  size_t length = brace_unstuff(chunk, size, body);
  if (length < sizeof header + 2) return 0;
  length -= 2;
  uint16_t sent = (uint16_t)(body[length] | (body[length + 1] << 8));
  if (brace_crc16(body, length) != sent) return 0;
  memcpy(&header, body, sizeof header);
  size_t payload = brace_payload_size(header.type);
  if (header.version != BRACE_VERSION || payload == 0) return 0;
  return length == sizeof header + payload ? length : 0;
}
