# A disassembly (objdump --demangle) in; for each function of `exported`, the calls into core within its reach that can
# panic out: "function: caller -> callee". Only direct calls and jumps are followed.

/^[0-9a-f]+ <.*>:$/ {
    name = $0
    sub(/^[0-9a-f]+ </, "", name)
    sub(/>:$/, "", name)
    next
}

/\t *(call|j[a-z]+|bl?|b\.[a-z]+|cbn?z|tbn?z)[ \t]/ && /<.*>/ {
    to = $0
    sub(/^[^<]*</, "", to)
    sub(/(\+0x[0-9a-f]+)?>[^>]*$/, "", to)
    if (to != name && !((name, to) in edge)) {
        edge[name, to]
        callees[name] = callees[name] SUBSEP to
    }
}

# Fills the array `found` with all that `start` can reach, itself included.
function reach(start, found,    queue, head, tail, list, n, i) {
    delete found
    queue[tail = 1] = start
    found[start]
    for (head = 1; head <= tail; head++) {
        n = split(callees[queue[head]], list, SUBSEP)
        for (i = 1; i <= n; i++)
            if (list[i] != "" && !(list[i] in found)) {
                found[list[i]]
                queue[++tail] = list[i]
            }
    }
}

function panics(start,    found, to) {
    if (!(start in known)) {
        known[start] = 0
        reach(start, found)
        for (to in found)
            if (to ~ /^core::panicking::/)
                known[start] = 1
    }
    return known[start]
}

END {
    n = split(exported, roots, /[ \n]+/)
    for (r = 1; r <= n; r++) {
        reach(roots[r], within)
        for (from in within) {
            m = split(from ~ /^core::/ ? "" : callees[from], list, SUBSEP)
            for (i = 1; i <= m; i++)
                if (list[i] ~ /^core::/ && panics(list[i]))
                    print "  " roots[r] ": " from " -> " list[i]
        }
    }
}
